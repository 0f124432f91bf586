//! Reads parts of a file by their positions, without seeking where they follow each other.

use std::fs::File;
use std::io::{BufReader, Read, Seek};

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
    /// Takes a file, which may have been read to any position.
    pub fn new(mut file: File) -> std::io::Result<Self> {
        file.rewind()?;
        Ok(Self { reader: BufReader::with_capacity(BUFFER, file), at: 0, bytes: Vec::new() })
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
