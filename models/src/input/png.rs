//! Pictures in the format PNG (ISO/IEC 15948), without interlacing: the grey or red values.
//!
//! The general readers support whole pictures and bring several crates. The only part of them that
//! heights need beyond `flate2` is the reversal of the five filters.

use flate2::read::ZlibDecoder;
use std::io::Read;

const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// A picture that is still packed.
pub struct Png {
    /// Columns of values.
    pub columns: u32,
    /// Rows of values.
    pub rows: u32,
    /// Bits of a value, 1 to 16.
    pub depth: u8,
    /// Colour type of the format.
    pub colour: u8,
    /// Whether it is interlaced; then its values cannot be read.
    pub is_interlaced: bool,
    /// Red values of the palette.
    palette: Vec<u8>,
    data: Vec<u8>,
}

/// Reads the chunks of a picture.
///
/// # Errors
/// A file that is no PNG, or damaged.
pub fn read(bytes: &[u8]) -> Result<Png, String> {
    let mut rest = bytes.strip_prefix(SIGNATURE).ok_or("the file is not a PNG")?;
    let mut png: Option<Png> = None;
    loop {
        let (kind, content) = next_chunk(&mut rest)?;
        match (&kind, &mut png) {
            (b"IHDR", None) => png = Some(header(content)?),
            (b"IHDR", Some(_)) | (_, None) => return Err("the PNG is damaged: it must begin with one header".into()),
            (b"PLTE", Some(png)) => png.palette = content.chunks_exact(3).map(|rgb| rgb[0]).collect(),
            (b"IDAT", Some(png)) => png.data.extend_from_slice(content),
            (b"IEND", Some(_)) => break,
            _ => {}
        }
    }
    png.ok_or_else(|| "the PNG is damaged: it has no header".into())
}

impl Png {
    /// The kind of its pixels.
    pub fn kind(&self) -> &'static str {
        match self.colour {
            0 => "greyscale",
            2 => "RGB",
            3 => "a palette",
            4 => "greyscale with transparency",
            6 => "RGB with transparency",
            _ => "an unknown kind",
        }
    }

    /// Grey values, or red ones of a coloured picture, row by row from the top, and the greatest
    /// possible value. Memory is bounded by the size that the header gives.
    ///
    /// # Errors
    /// Pixels that are damaged, interlaced or of an unknown kind.
    pub fn values(&self) -> Result<(Vec<u16>, u16), String> {
        if self.is_interlaced {
            return Err("the PNG is interlaced, which is not read: save it without interlacing".into());
        }
        let channels = match (self.colour, self.depth) {
            (0, 1 | 2 | 4 | 8 | 16) | (3, 1 | 2 | 4 | 8) => 1,
            (2, 8 | 16) => 3,
            (4, 8 | 16) => 2,
            (6, 8 | 16) => 4,
            _ => return Err(format!("the PNG has {} of {} bits, which is not read", self.kind(), self.depth)),
        };
        let (columns, rows) = (self.columns as usize, self.rows as usize);
        let bits = channels * usize::from(self.depth);
        let (pixel, stride) = (bits.div_ceil(8), 1 + (columns * bits).div_ceil(8));
        let mut lines = Vec::new();
        let read = ZlibDecoder::new(&*self.data).take((rows * stride) as u64 + 1).read_to_end(&mut lines);
        read.map_err(|e| format!("the PNG is damaged: its pixels cannot be unpacked: {e}"))?;
        if lines.len() != rows * stride {
            return Err("the PNG is damaged: the number of its pixels is not that of its header".into());
        }
        let mut values = Vec::with_capacity(rows * columns);
        let mut above = vec![0; stride - 1];
        for line in lines.chunks_exact_mut(stride) {
            let (filter, pixels) = line.split_at_mut(1);
            reverse_filter(filter[0], pixels, &above, pixel)?;
            values.extend((0..columns).map(|column| first_value(pixels, column * bits, self.depth)));
            above.copy_from_slice(pixels);
        }
        if self.colour != 3 {
            return Ok((values, u16::MAX >> (16 - self.depth)));
        }
        let red = |index: u16| self.palette.get(usize::from(index)).map(|red| u16::from(*red));
        let values: Option<Vec<u16>> = values.into_iter().map(red).collect();
        Ok((values.ok_or("the PNG is damaged: a pixel has no colour in the palette")?, 255))
    }
}

/// The value that begins at a bit.
fn first_value(pixels: &[u8], bit: usize, depth: u8) -> u16 {
    match depth {
        16 => u16::from_be_bytes([pixels[bit / 8], pixels[bit / 8 + 1]]),
        8 => u16::from(pixels[bit / 8]),
        _ => u16::from(pixels[bit / 8] >> (8 - usize::from(depth) - bit % 8) & (0xff >> (8 - depth))),
    }
}

/// Takes a chunk, whose checksum must be right: its type and its content.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Result<([u8; 4], &'a [u8]), String> {
    let ended = || "the PNG is damaged: it ends within a chunk".to_owned();
    let (length, after) = rest.split_first_chunk::<4>().ok_or_else(ended)?;
    let length = u32::from_be_bytes(*length) as usize;
    let (kind, _) = after.split_first_chunk::<4>().ok_or_else(ended)?;
    let (covered, after) = after.split_at_checked(length.saturating_add(4)).ok_or_else(ended)?;
    let (checksum, after) = after.split_first_chunk::<4>().ok_or_else(ended)?;
    let mut crc = flate2::Crc::new();
    crc.update(covered);
    if crc.sum() != u32::from_be_bytes(*checksum) {
        let kind = String::from_utf8_lossy(kind);
        return Err(format!("the PNG is damaged: the checksum of a chunk {kind:?} is wrong"));
    }
    *rest = after;
    Ok((*kind, &covered[4..]))
}

fn header(content: &[u8]) -> Result<Png, String> {
    let Ok([w0, w1, w2, w3, h0, h1, h2, h3, depth, colour, compression, filter, interlace]) =
        <[u8; 13]>::try_from(content)
    else {
        return Err("the PNG is damaged: its header must have 13 bytes".into());
    };
    if (compression, filter) != (0, 0) {
        return Err("the PNG has an unknown compression or filter".into());
    }
    let (columns, rows) = (u32::from_be_bytes([w0, w1, w2, w3]), u32::from_be_bytes([h0, h1, h2, h3]));
    let (palette, data) = (Vec::new(), Vec::new());
    Ok(Png { columns, rows, depth, colour, is_interlaced: interlace != 0, palette, data })
}

/// Reverses the filter of a line in place (PNG specification, 9.2). `pixel` is the number of bytes
/// of a pixel, at least 1.
fn reverse_filter(filter: u8, line: &mut [u8], above: &[u8], pixel: usize) -> Result<(), String> {
    for i in 0..line.len() {
        let left = if i < pixel { 0 } else { line[i - pixel] };
        let (up, corner) = (above[i], if i < pixel { 0 } else { above[i - pixel] });
        let prediction = match filter {
            0 => return Ok(()),
            1 => left,
            2 => up,
            3 => ((u16::from(left) + u16::from(up)) / 2) as u8,
            4 => paeth(left, up, corner),
            _ => return Err(format!("the PNG is damaged: a line has the filter {filter}")),
        };
        line[i] = line[i].wrapping_add(prediction);
    }
    Ok(())
}

/// Paeth's predictor: of left, up and corner the one nearest to left + up - corner.
pub fn paeth(left: u8, up: u8, corner: u8) -> u8 {
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
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    fn file(columns: u32, kind: [u8; 2], palette: &[u8], lines: &[u8]) -> Vec<u8> {
        let chunk = |kind: &[u8; 4], content: &[u8]| {
            let mut crc = flate2::Crc::new();
            crc.update(kind);
            crc.update(content);
            [&(content.len() as u32).to_be_bytes(), &kind[..], content, &crc.sum().to_be_bytes()].concat()
        };
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(lines).unwrap();
        let header = [&columns.to_be_bytes()[..], &1u32.to_be_bytes(), &kind, &[0; 3]].concat();
        let (header, palette) = (chunk(b"IHDR", &header), chunk(b"PLTE", palette));
        let data = chunk(b"IDAT", &packed.finish().unwrap());
        [SIGNATURE, &header, &palette, &data, &chunk(b"IEND", b"")].concat()
    }

    #[test]
    fn each_kind_of_pixel_gives_its_first_value() {
        let palette = [10, 0, 0, 20, 0, 0, 30, 0, 0, 40, 0, 0];
        for (kind, columns, line, expected, greatest) in [
            ([1, 0], 10, &[0, 0b1010_0000, 0b0100_0000][..], &[1, 0, 1, 0, 0, 0, 0, 0, 0, 1][..], 1),
            ([2, 3], 4, &[0, 0b0001_1011], &[10, 20, 30, 40], 255),
            ([4, 0], 3, &[0, 0x1f, 0x70], &[1, 15, 7], 15),
            ([8, 0], 2, &[1, 5, 6], &[5, 11], 255),
            ([8, 2], 2, &[1, 5, 1, 1, 6, 1, 1], &[5, 11], 255),
            ([8, 4], 2, &[1, 5, 1, 6, 1], &[5, 11], 255),
            ([16, 6], 1, &[0, 1, 2, 0, 0, 0, 0, 0, 0], &[258], 65535),
        ] {
            let png = read(&file(columns, kind, &palette, line)).unwrap();
            assert_eq!(png.values().unwrap(), (expected.to_vec(), greatest), "{kind:?}");
        }
        let error = |kind, line: &[u8]| read(&file(2, kind, &palette[..6], line)).unwrap().values().unwrap_err();
        assert!(error([2, 3], &[0, 0xff]).contains("no colour in the palette"));
        assert!(error([4, 2], &[0, 0]).contains("RGB of 4 bits"));
    }
}
