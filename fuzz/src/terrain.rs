//! Files of terrain; the first byte selects the kind.

use std::path::PathBuf;

use stiction::assemble;
use stiction::nalgebra::Vector3;
use stiction::scenario::Run;
use stiction::terrain::TerrainPiece;

use super::{scenario, tree};

/// Kinds by letter: the keys of the entry. The files are replaced.
pub const KINDS: [(u8, &str); 4] = [
    (b'c', "type = 'heightfield', file = '../tests/scenario/bumps.csv', spacing = 0.1"),
    (b'p', "type = 'heightfield', file = '../tests/scenario/bumps.png', size = [1, 2], height = [-1, 2]"),
    (b't', "type = 'mesh', file = '../tests/scenario/stone.obj'"),
    (b'h', "type = 'mesh', file = '../tests/scenario/stone.obj', as = 'convex', rpy = [1, 2, 3]"),
];

thread_local! {
    static RUNS: Vec<(u8, Run)> = KINDS.iter().map(|(kind, keys)| {
        let text = format!("robot.model = '../robots/block/block.toml'\nterrain = [{{ {keys} }}]\n");
        (*kind, tree::run(&text))
    }).collect();
}

/// Reads a file of terrain; the first byte is the letter of its kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let run = RUNS.with(|runs| runs.iter().find(|(k, _)| k == kind).map(|(_, run)| run.clone()));
    let Some(mut run) = run else { return };
    let is_picture = run.inputs[0].path.extension() == PathBuf::from("x.png").extension();
    run.inputs[0].bytes = if is_picture { with_checksums(bytes).into() } else { bytes.into() };
    let mut errors = Vec::new();
    let terrain = assemble::terrain::terrain(&run, None, &mut Vec::new(), &mut errors);
    if !errors.is_empty() {
        return scenario::show(&stiction::scenario::Diagnostics(errors));
    }
    let (mut buffer, mut found) = (TerrainPiece::prism_buffer(), 0);
    for size in [0.1, 1e9] {
        let half = Vector3::repeat(size);
        terrain.near(&-half, &half, |piece| {
            found += 1;
            if found < 1000 {
                let piece = terrain.piece(piece, &mut buffer);
                assert!(piece.points.iter().all(|p| p.iter().all(|x| x.is_finite())), "a corner is not finite");
                let corners = piece.faces.iter().flat_map(|face| &face.corners);
                assert!(corners.into_iter().all(|k| usize::from(*k) < piece.points.len()), "a corner is not there");
            }
        });
    }
    assert!(found > 0, "terrain without pieces");
}

/// The picture with right checksums of its chunks: otherwise it would only be refused for these.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut fixed = bytes.to_vec();
    let mut at = 8;
    while let Some(length) = fixed.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let Some(end) = at.checked_add(8).and_then(|content| content.checked_add(length)) else { break };
        let Some(covered) = fixed.get(at + 4..end) else { break };
        let sum = crc32(covered).to_be_bytes();
        let Some(stored) = fixed.get_mut(end..end + 4) else { break };
        stored.copy_from_slice(&sum);
        at = end + 4;
    }
    fixed
}

/// The checksum of PNG's chunks (PNG specification, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| if sum & 1 == 1 { 0xedb8_8320 ^ (sum >> 1) } else { sum >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}
