//! Floor 4: the only room that touches the file system.
