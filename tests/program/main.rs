//! The program as it is started: files, commands, signals, hostile input; and the order of its
//! rooms.

mod binary;
mod command_line;
mod data;
mod files;
mod floors;
mod guide;
mod height_formats;
mod heights;
mod hostile_scenes;
mod kills;
mod scene_files;
mod sweep;
mod units;
