//! Reads parts of a file by their positions, without seeking where they follow each other.

use std::fs::File;
use std::io::{BufReader, Read};

/// Size of the buffer, bytes: some dozens of rows.
const BUFFER: usize = 256 << 10;

/// Part of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub offset: u64,
    pub length: usize,
}

/// A file whose parts are read.
pub(super) struct FileSpans {
    reader: BufReader<File>,
    at: u64,
    bytes: Vec<u8>,
}

impl FileSpans {
    /// Reads from the beginning of a file.
    pub fn new(file: File) -> Self {
        Self { reader: BufReader::with_capacity(BUFFER, file), at: 0, bytes: Vec::new() }
    }

    /// Reads the file in order. To be called before [`FileSpans::read`], which continues where
    /// `consume` ended, at a distance of `at` bytes from the beginning.
    pub fn reader(&mut self) -> &mut BufReader<File> {
        &mut self.reader
    }

    /// Sets the position to which the reader was read.
    pub fn set_position(&mut self, at: u64) {
        self.at = at;
    }

    /// Reads a part.
    pub fn read(&mut self, span: Span) -> std::io::Result<&[u8]> {
        let distance = i64::try_from(i128::from(span.offset) - i128::from(self.at)).map_err(std::io::Error::other)?;
        self.reader.seek_relative(distance)?;
        self.bytes.resize(span.length, 0);
        self.reader.read_exact(&mut self.bytes)?;
        self.at = span.offset + span.length as u64;
        Ok(&self.bytes)
    }
}
