//! The one binary: reads the command line and hands over.

fn main() -> std::process::ExitCode {
    tackscope::cli::main()
}
