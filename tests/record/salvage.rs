//! Recovery of damaged and unfinished logs: what is recovered is equal to that part of the whole
//! log, and everything else is counted.

use std::fs;
use std::path::{Path, PathBuf};

use stiction::log::{LogError, SalvageError, Trajectory, salvage};

use crate::cli::Place;

/// A run with a log of several chunks, and the path of its log.
fn logged() -> (Place, PathBuf) {
    let place = Place::new();
    place.block("s.toml", "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1] }\n[log]\nrate = 4000\n");
    place.runner(&["s.toml", "--set", "duration=1"]).exits(0);
    let key = place.summary("results").column("key")[0].to_owned();
    let log = place.path("results/s").join(key).join("log.mcap");
    (place, log)
}

/// Positions of the records of a file: kind, begin and end.
fn records(bytes: &[u8]) -> Vec<(u8, usize, usize)> {
    let (mut at, mut found) = (8, Vec::new());
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        found.push((bytes[at], at, at + 9 + length));
        at += 9 + length;
    }
    found
}

fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let chunks: Vec<_> = records(bytes).into_iter().filter(|r| r.0 == mcap::records::op::CHUNK).collect();
    assert!(chunks.len() >= 4, "{} chunks", chunks.len());
    chunks.into_iter().map(|(_, begin, end)| (begin, end)).collect()
}

/// The ticks of `part` are ticks of `whole`, with equal values; returns their positions.
fn positions(part: &Trajectory, whole: &Trajectory) -> Vec<usize> {
    let position = |time: f64| whole.times.iter().position(|t| *t == time).expect("a tick of the whole log");
    let found: Vec<usize> = part.times.iter().map(|t| position(*t)).collect();
    let (a, b) = (part.motion.as_ref().unwrap(), whole.motion.as_ref().unwrap());
    let (c, d) = (part.soles.as_ref().unwrap(), whole.soles.as_ref().unwrap());
    for (i, &j) in found.iter().enumerate() {
        assert_eq!(a.base_position[i], b.base_position[j]);
        assert_eq!(c[0].force[i], d[0].force[j]);
    }
    found
}

fn read(path: &Path) -> Trajectory {
    Trajectory::read(path).unwrap()
}

#[test]
fn a_whole_log_is_recovered_whole() {
    let (place, log) = logged();
    let to = place.path("out.mcap");
    let salvaged = salvage(&log, &to).unwrap();
    assert!(
        salvaged.whole
            && salvaged.damaged_chunks + salvaged.damaged_records + salvaged.incomplete + salvaged.unread_bytes == 0,
        "{salvaged:?}"
    );
    let (part, whole) = (read(&to), read(&log));
    assert!(part == whole && part.complete);
}

#[test]
fn a_cut_log_is_recovered_up_to_the_cut() {
    let (place, log) = logged();
    let (bytes, whole, to) = (fs::read(&log).unwrap(), read(&log), place.path("out.mcap"));
    let chunks = chunks(&bytes);
    for (cut, least) in
        [(chunks[1].1, 2), (chunks[2].0 + 300, 2), (chunks[2].1 - 1, 2), (bytes.len() - 20, chunks.len())]
    {
        fs::write(place.path("cut.mcap"), &bytes[..cut]).unwrap();
        let salvaged = salvage(&place.path("cut.mcap"), &to).unwrap();
        assert!(!salvaged.whole && salvaged.damaged_chunks == 0, "{salvaged:?}");
        let part = read(&to);
        assert!(!part.complete);
        let found = positions(&part, &whole);
        // Every tick up to the cut but the last, which may be incomplete.
        assert_eq!(found, (0..found.len()).collect::<Vec<_>>());
        let all = whole.times.len() * least / chunks.len();
        assert!(found.len() + 2 >= all.min(whole.times.len()), "{} of {}", found.len(), whole.times.len());
    }
}

/// A killed program leaves a chunk whose length and checksum are not yet known.
#[test]
fn messages_of_an_unfinished_chunk_are_recovered() {
    let (place, log) = logged();
    let (bytes, whole, to) = (fs::read(&log).unwrap(), read(&log), place.path("out.mcap"));
    let (begin, end) = chunks(&bytes)[1];
    let mut unfinished = bytes[..begin + (end - begin) * 3 / 4].to_vec();
    unfinished[begin + 1..begin + 9].fill(0xff);
    let header = begin + 9;
    // Times are 0, lengths and checksum all ones until the chunk is closed.
    unfinished[header..header + 16].fill(0);
    unfinished[header + 16..header + 28].fill(0xff);
    let name = u32::from_le_bytes(unfinished[header + 28..header + 32].try_into().unwrap()) as usize;
    unfinished[header + 32 + name..header + 40 + name].fill(0xff);
    let path = place.path("results/s/.log.mcap.Ab12.partial");
    fs::write(&path, &unfinished).unwrap();
    let without = salvage_cut(&place, &bytes[..begin], &whole);
    salvage(&path, &to).unwrap();
    let found = positions(&read(&to), &whole);
    assert_eq!(found, (0..found.len()).collect::<Vec<_>>());
    assert!(found.len() > without + 100, "{} ticks, {without} without the chunk", found.len());
    // As a user does it.
    let done = place.runner(&["salvage", "results"]).exits(0);
    assert!(done.stdout.starts_with("results/s/salvaged-Ab12.mcap: "), "{}", done.stdout);
    assert!(done.stdout.contains("of incomplete ticks"), "{}", done.stdout);
    assert_eq!(fs::read(place.path("results/s/salvaged-Ab12.mcap")).unwrap(), fs::read(&to).unwrap());
    place.runner(&["export", "results/s/salvaged-Ab12.mcap"]).exits(0);
}

fn salvage_cut(place: &Place, bytes: &[u8], whole: &Trajectory) -> usize {
    fs::write(place.path("cut.mcap"), bytes).unwrap();
    salvage(&place.path("cut.mcap"), &place.path("cut-out.mcap")).unwrap();
    positions(&read(&place.path("cut-out.mcap")), whole).len()
}

#[test]
fn a_damaged_chunk_is_left_out_and_counted() {
    let (place, log) = logged();
    let (bytes, whole, to) = (fs::read(&log).unwrap(), read(&log), place.path("out.mcap"));
    let (begin, end) = chunks(&bytes)[2];
    for at in [begin + 60, (begin + end) / 2, end - 5] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        fs::write(&log, &damaged).unwrap();
        assert!(matches!(Trajectory::read(&log), Err(LogError::Damaged { .. })));
        let salvaged = salvage(&log, &to).unwrap();
        assert_eq!(salvaged.damaged_chunks, 1, "{salvaged:?}");
        let found = positions(&read(&to), &whole);
        let gaps = found.windows(2).filter(|pair| pair[1] != pair[0] + 1).count();
        assert_eq!((gaps, found[0], *found.last().unwrap()), (1, 0, whole.times.len() - 1));
        assert!(!read(&to).complete);
    }
    let key = log.parent().unwrap().file_name().unwrap().to_str().unwrap().to_owned();
    let done = place.runner(&["salvage", log.to_str().unwrap()]).exits(0);
    assert!(
        done.stdout.contains(&format!("{key}/salvaged.mcap: ")) && done.stdout.contains("1 damaged chunk"),
        "{}",
        done.stdout
    );
}

/// Damage outside of chunks: an attachment has a checksum of its own, metadata only that of all data.
#[test]
fn damaged_records_outside_of_chunks_are_never_called_whole() {
    let (place, log) = logged();
    let (bytes, whole, to) = (fs::read(&log).unwrap(), read(&log), place.path("out.mcap"));
    let find = |kind: u8| records(&bytes).into_iter().find(|record| record.0 == kind).unwrap();
    let from = place.path("damaged.mcap");
    let attachment = find(mcap::records::op::ATTACHMENT);
    // All of its header, and parts of its data.
    let begin = attachment.1 + 9;
    for at in (begin..begin + 60).chain((begin + 60..attachment.2).step_by(97)) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        fs::write(&from, &damaged).unwrap();
        let salvaged = salvage(&from, &to).unwrap();
        assert!(!salvaged.whole && salvaged.damaged_records == 1, "byte {at}: {salvaged:?}");
        assert_eq!(read(&to).attachments, whole.attachments[1..]);
    }
    // A letter of a name in the metadata of the run.
    let metadata = find(mcap::records::op::METADATA);
    let name = bytes[metadata.1..metadata.2].windows(6).position(|w| w == b"robot\0" || w == b"method").unwrap();
    let value = metadata.1 + name + 11;
    let mut damaged = bytes.clone();
    damaged[value] ^= 1;
    fs::write(&from, &damaged).unwrap();
    let salvaged = salvage(&from, &to).unwrap();
    assert!(!salvaged.whole && salvaged.damaged_records == 0, "{salvaged:?}");
    assert!(!read(&to).complete);
    let done = place.runner(&["salvage", "damaged.mcap"]).exits(0);
    assert!(done.stdout.ends_with("; the log does not match its checksums\n"), "{}", done.stdout);
}

#[test]
fn files_without_messages_are_refused() {
    let (place, log) = logged();
    let bytes = fs::read(&log).unwrap();
    for (name, content) in [("empty", &b""[..]), ("text", b"hello"), ("start", &bytes[..200])] {
        fs::write(place.path(name), content).unwrap();
        let error = salvage(&place.path(name), &place.path("out.mcap")).unwrap_err();
        assert!(matches!(error, SalvageError::Read(LogError::Foreign { .. })), "{error}");
        assert!(!place.path("out.mcap").exists());
    }
    fs::write(place.path("notes.txt"), "mine").unwrap();
    let error = salvage(&log, &place.path("notes.txt")).unwrap_err();
    assert!(matches!(error, SalvageError::Write(_)), "{error}");
    assert_eq!(fs::read_to_string(place.path("notes.txt")).unwrap(), "mine");
    place.runner(&["salvage", "results"]).exits(4);
    place.runner(&["salvage", "results/s", "empty"]).exits(2);
    place.runner(&["salvage", "nothing.mcap"]).exits(2);
}

/// Every cut and many damages of a small log give a readable log or an error.
#[test]
fn no_cut_and_no_damage_gives_an_unreadable_log() {
    let place = Place::new();
    place.block("s.toml", "[log]\nrate = 100\n");
    place.runner(&["s.toml", "--set", "duration=0.05"]).exits(0);
    let key = place.summary("results").column("key")[0].to_owned();
    let bytes = fs::read(place.path("results/s").join(key).join("log.mcap")).unwrap();
    let (from, to) = (place.path("from.mcap"), place.path("to.mcap"));
    let mut recovered = 0;
    let mut check = |content: &[u8]| {
        fs::write(&from, content).unwrap();
        if salvage(&from, &to).is_ok() {
            read(&to);
            recovered += 1;
        }
    };
    (0..bytes.len()).step_by(97).for_each(|length| check(&bytes[..length]));
    for at in (8..bytes.len()).step_by(89) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        check(&damaged);
    }
    assert!(recovered > 20, "{recovered}");
}
