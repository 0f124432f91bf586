//! Pictures in the format PNG (ISO/IEC 15948), of 16-bit greyscale without interlacing.
//!
//! The general readers support all kinds of pixels and bring several crates. The only part of
//! them that this kind needs beyond `flate2` is the reversal of the five filters.

use super::heights::{Heights, HeightsError, MAX_POINTS, check_size};
use flate2::read::ZlibDecoder;
use std::io::Read;

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Bytes of a pixel.
const PIXEL: usize = 2;

/// Reads a picture; its values are from 0 (black) to 65535 (white).
pub(super) fn read(bytes: &[u8]) -> Result<Heights, HeightsError> {
    let mut rest = bytes.strip_prefix(SIGNATURE).ok_or_else(|| HeightsError::new("the file is not a PNG"))?;
    let mut size = None;
    let mut data = Vec::new();
    loop {
        let (kind, content) = next_chunk(&mut rest)?;
        match (&kind, size) {
            (b"IHDR", None) => size = Some(read_header(content)?),
            (b"IHDR", Some(_)) | (_, None) => {
                return Err(HeightsError::new("the PNG is damaged: it must begin with one header"));
            }
            (b"IDAT", _) => data.extend_from_slice(content),
            (b"IEND", _) => break,
            _ => {}
        }
    }
    let (columns, rows) = size.unwrap_or_default();
    let stride = 1 + PIXEL * columns;
    let mut lines = Vec::new();
    let read = ZlibDecoder::new(&*data).take((rows * stride) as u64 + 1).read_to_end(&mut lines);
    read.map_err(|e| HeightsError::new(format!("the PNG is damaged: its pixels cannot be unpacked: {e}")))?;
    if lines.len() != rows * stride {
        return Err(HeightsError::new("the PNG is damaged: the number of its pixels is not that of its header"));
    }
    let mut values = Vec::with_capacity(rows * columns);
    let mut above = vec![0; stride - 1];
    for line in lines.chunks_exact_mut(stride) {
        let (filter, pixels) = line.split_at_mut(1);
        reverse_filter(filter[0], pixels, &above)?;
        values.extend(pixels.chunks_exact(PIXEL).map(|p| f64::from(u16::from_be_bytes([p[0], p[1]]))));
        above.copy_from_slice(pixels);
    }
    Ok(Heights { rows, columns, values })
}

/// Takes a chunk, whose checksum must be right: its type and its content.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Result<([u8; 4], &'a [u8]), HeightsError> {
    let ended = || HeightsError::new("the PNG is damaged: it ends within a chunk");
    let (length, after) = rest.split_first_chunk::<4>().ok_or_else(ended)?;
    let length = u32::from_be_bytes(*length) as usize;
    let (kind, _) = after.split_first_chunk::<4>().ok_or_else(ended)?;
    let (covered, after) = after.split_at_checked(length.saturating_add(4)).ok_or_else(ended)?;
    let (checksum, after) = after.split_first_chunk::<4>().ok_or_else(ended)?;
    let mut crc = flate2::Crc::new();
    crc.update(covered);
    if crc.sum() != u32::from_be_bytes(*checksum) {
        let kind = String::from_utf8_lossy(kind);
        return Err(HeightsError::new(format!("the PNG is damaged: the checksum of a chunk {kind:?} is wrong")));
    }
    *rest = after;
    Ok((*kind, &covered[4..]))
}

/// Columns and rows of a header.
fn read_header(content: &[u8]) -> Result<(usize, usize), HeightsError> {
    let Ok([w0, w1, w2, w3, h0, h1, h2, h3, depth, colour, compression, filter, interlace]) =
        <[u8; 13]>::try_from(content)
    else {
        return Err(HeightsError::new("the PNG is damaged: its header must have 13 bytes"));
    };
    let (columns, rows) = (u32::from_be_bytes([w0, w1, w2, w3]), u32::from_be_bytes([h0, h1, h2, h3]));
    if (depth, colour) != (16, 0) {
        let found = match colour {
            0 => "greyscale",
            2 => "RGB",
            3 => "a palette",
            4 => "greyscale with transparency",
            6 => "RGB with transparency",
            _ => "an unknown kind",
        };
        return Err(HeightsError::new(format!("the PNG must have 16-bit greyscale, not {found} of {depth} bits")));
    }
    if interlace != 0 {
        return Err(HeightsError::new("the PNG is interlaced, which is not read: save it without interlacing"));
    }
    if (compression, filter) != (0, 0) {
        return Err(HeightsError::new("the PNG has an unknown compression or filter"));
    }
    check_size(rows as usize, columns as usize)?;
    debug_assert!(rows as usize <= MAX_POINTS && columns as usize <= MAX_POINTS);
    Ok((columns as usize, rows as usize))
}

/// Reverses the filter of a line in place (PNG specification, 9.2).
fn reverse_filter(filter: u8, line: &mut [u8], above: &[u8]) -> Result<(), HeightsError> {
    for i in 0..line.len() {
        let left = if i < PIXEL { 0 } else { line[i - PIXEL] };
        let (up, corner) = (above[i], if i < PIXEL { 0 } else { above[i - PIXEL] });
        let prediction = match filter {
            0 => return Ok(()),
            1 => left,
            2 => up,
            3 => ((u16::from(left) + u16::from(up)) / 2) as u8,
            4 => paeth(left, up, corner),
            _ => return Err(HeightsError::new(format!("the PNG is damaged: a line has the filter {filter}"))),
        };
        line[i] = line[i].wrapping_add(prediction);
    }
    Ok(())
}

/// Paeth's predictor: of left, up and corner the one nearest to left + up - corner.
fn paeth(left: u8, up: u8, corner: u8) -> u8 {
    let [a, b, c] = [left, up, corner].map(i32::from);
    let p = a + b - c;
    let [pa, pb, pc] = [a, b, c].map(|x| (p - x).abs());
    if pa <= pb && pa <= pc {
        left
    } else if pb <= pc {
        up
    } else {
        corner
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
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
