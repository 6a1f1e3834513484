//! A run as a library: what a program or another language calls.

pub mod info;
