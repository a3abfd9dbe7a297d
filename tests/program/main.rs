//! The program as it is started: files, commands, signals, hostile input; and the order of its
//! rooms.

mod binary;
mod command_line;
mod data;
mod explorer;
mod files;
mod floors;
mod height_formats;
mod heights;
mod hostile_scenes;
mod kills;
mod lessons;
mod scene_files;
mod sweep;
mod units;
