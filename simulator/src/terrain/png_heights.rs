//! Heights as pictures in the format PNG, of 16-bit greyscale without interlacing.

use super::heights::{Heights, HeightsError, check_size};
use crate::input::png;

/// Reads a picture; its values are from 0 (black) to 65535 (white).
pub(super) fn read(bytes: &[u8]) -> Result<Heights, HeightsError> {
    let png = png::read(bytes).map_err(HeightsError::new)?;
    if (png.depth, png.colour) != (16, 0) {
        let (kind, depth) = (png.kind(), png.depth);
        return Err(HeightsError::new(format!("the PNG must have 16-bit greyscale, not {kind} of {depth} bits")));
    }
    let (columns, rows) = (png.columns as usize, png.rows as usize);
    check_size(rows, columns)?;
    let (values, _) = png.values().map_err(HeightsError::new)?;
    Ok(Heights { rows, columns, values: values.into_iter().map(f64::from).collect() })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::input::png::paeth;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
        let mut crc = flate2::Crc::new();
        crc.update(kind);
        crc.update(content);
        [&(content.len() as u32).to_be_bytes(), &kind[..], content, &crc.sum().to_be_bytes()].concat()
    }

    fn header(columns: u32, rows: u32, kind: [u8; 5]) -> Vec<u8> {
        chunk(b"IHDR", &[&columns.to_be_bytes()[..], &rows.to_be_bytes(), &kind].concat())
    }

    const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
    /// Bytes of a pixel.
    const PIXEL: usize = 2;

    const GREY: [u8; 5] = [16, 0, 0, 0, 0];

    fn file(header: &[u8], lines: &[u8]) -> Vec<u8> {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(lines).unwrap();
        let packed = packed.finish().unwrap();
        let (first, second) = packed.split_at(packed.len() / 2);
        let text = chunk(b"tEXt", b"Comment\0heights");
        [SIGNATURE, header, &text, &chunk(b"IDAT", first), &chunk(b"IDAT", second), &chunk(b"IEND", b"")].concat()
    }

    /// A picture whose lines have this filter.
    pub fn encode(columns: usize, rows: usize, values: &[u16], filter: u8) -> Vec<u8> {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        let width = PIXEL * columns;
        let mut lines = Vec::new();
        for row in 0..rows {
            lines.push(filter);
            for i in 0..width {
                let at = |row: Option<usize>, i: Option<usize>| match (row, i) {
                    (Some(row), Some(i)) => bytes[row * width + i],
                    _ => 0,
                };
                let (above, before) = (row.checked_sub(1), i.checked_sub(PIXEL));
                let (left, up, corner) = (at(Some(row), before), at(above, Some(i)), at(above, before));
                let prediction = match filter {
                    0 => 0,
                    1 => left,
                    2 => up,
                    3 => ((u16::from(left) + u16::from(up)) / 2) as u8,
                    _ => paeth(left, up, corner),
                };
                lines.push(bytes[row * width + i].wrapping_sub(prediction));
            }
        }
        file(&header(columns as u32, rows as u32, GREY), &lines)
    }

    #[test]
    fn other_pictures_are_refused() {
        let message = |bytes: &[u8]| read(bytes).unwrap_err().message;
        assert_eq!(message(b"GIF89a"), "the file is not a PNG");
        let lines = [0; 10];
        assert_eq!(
            message(&file(&header(2, 2, [8, 2, 0, 0, 0]), &lines)),
            "the PNG must have 16-bit greyscale, not RGB of 8 bits"
        );
        assert!(message(&file(&header(2, 2, [8, 0, 0, 0, 0]), &lines)).ends_with("not greyscale of 8 bits"));
        assert!(message(&file(&header(2, 2, [16, 0, 0, 0, 1]), &lines)).contains("is interlaced"));
        assert!(message(&file(&header(2, 1, GREY), &lines)).starts_with("the grid has 1 x 2 heights"));
        assert!(message(&file(&header(2, u32::MAX, GREY), &lines)).contains("from 2 to 4096 rows and columns"));
        assert!(read(&file(&header(2, 2, GREY), &lines)).is_ok());
    }

    #[test]
    fn damaged_pictures_are_refused() {
        let message = |bytes: &[u8]| read(bytes).unwrap_err().message;
        let whole = encode(2, 2, &[1, 2, 3, 4], 4);
        for end in SIGNATURE.len()..whole.len() {
            assert!(message(&whole[..end]).contains("ends within a chunk"), "{end}");
        }
        for at in SIGNATURE.len() + 8..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            assert!(message(&bytes).starts_with("the PNG is damaged"), "{at}: {}", message(&bytes));
        }
        assert!(message(&file(&header(2, 3, GREY), &[0; 10])).contains("the number of its pixels"));
        assert!(message(&file(&header(2, 2, GREY), &[0; 11])).contains("the number of its pixels"));
        assert!(message(&file(&header(2, 2, GREY), &[9; 10])).ends_with("a line has the filter 9"));
        let twice = [header(2, 2, GREY), header(2, 2, GREY)].concat();
        assert!(message(&file(&twice, &[0; 10])).ends_with("must begin with one header"));
        assert!(message(&file(&chunk(b"IHDR", b"x"), &[0; 10])).ends_with("its header must have 13 bytes"));
    }
}
