//! MCAP as a reader may encounter it: truncated anywhere, damaged, and from other tools.

use std::fs::File;
use std::path::PathBuf;

use cosim::observe::McapRecorder;
use cosim::{Overrides, Recording};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use tempfile::TempDir;

use crate::models::Model::{Clock, Integrator};
use crate::ssd::Ssd;

/// A run's results in memory and as a file.
fn results(folder: &TempDir) -> (Recording, PathBuf) {
    let system = Ssd::new().add("a", Clock).add("b", Integrator).connect("a.y", "b.u").stop(2.0);
    let (system, mut memory) = (system.load(&Overrides::new()).unwrap(), Recording::new());
    let file = folder.path().join("results.mcap");
    system.run(&mut [&mut memory, &mut McapRecorder::create(&file).unwrap()]).unwrap();
    (memory, file)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// `read` is the beginning of `whole`.
fn begins(whole: &Recording, read: &Recording) -> bool {
    let count = read.time().len();
    bits(&whole.time()[..count]) == bits(read.time())
        && read.columns().all(|(name, values)| {
            bits(&whole.column(name).unwrap()[..count]) == bits(values) && values.len() == count
        })
}

#[test]
fn a_file_cut_at_any_byte_is_read_as_far_as_it_goes() {
    let folder = TempDir::new().unwrap();
    let (whole, file) = results(&folder);
    let (bytes, cut) = (std::fs::read(&file).unwrap(), folder.path().join("cut.mcap"));
    let mut longest = 0;
    for length in 0..bytes.len() {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let read = cosim::observe::read(&cut);
        if length < 8 {
            assert!(read.unwrap_err().to_string().contains("not MCAP"), "{length}");
            continue;
        }
        let read = read.unwrap_or_else(|error| panic!("{length}: {error}"));
        assert!(begins(&whole, &read), "{length}");
        assert!(read.time().len() >= longest, "{length}");
        assert!(read.missing().is_some() || read.time() == whole.time(), "{length}");
        longest = read.time().len();
    }
    assert_eq!(longest, whole.time().len());
    assert_eq!(cosim::observe::read(&file).unwrap().missing(), None);
}

/// The samples are those of the file as written, or the damage is reported.
#[test]
fn no_bit_turns_unseen_in_the_samples() {
    let folder = TempDir::new().unwrap();
    let (whole, file) = results(&folder);
    let (bytes, damaged) = (std::fs::read(&file).unwrap(), folder.path().join("damaged.mcap"));
    let chunk = 8 + 9 + bytes[9] as usize;
    assert_eq!(bytes[chunk], 6);
    let length = u64::from_le_bytes(bytes[chunk + 1..chunk + 9].try_into().unwrap()) as usize;
    for at in chunk + 9 + 32 + 8..chunk + 9 + length {
        let mut wrong = bytes.clone();
        wrong[at] ^= 1 << (at % 8);
        std::fs::write(&damaged, &wrong).unwrap();
        let error = cosim::observe::read(&damaged).err().map(|error| error.to_string());
        let named = |error: String| error.contains("damaged.mcap") && error.contains("checksum");
        assert!(error.is_some_and(named), "{at}");
    }
    assert!(begins(&whole, &cosim::observe::read(&file).unwrap()));
}

/// Writes one double on a channel with this metadata, in this layout.
fn of_another_tool(options: WriteOptions, file: &PathBuf, listed: Option<&str>) {
    let mut writer = options.create(File::create(file).unwrap()).unwrap();
    let metadata = listed.map(|columns| ("cosim.columns".to_owned(), columns.to_owned()));
    let schema = writer.add_schema("other/msg/X", "ros2msg", b"float64 x").unwrap();
    let metadata = metadata.into_iter().collect();
    let channel_id = writer.add_channel(schema, "/other", "cdr", &metadata).unwrap();
    let header = MessageHeader { channel_id, sequence: 1, log_time: 5, publish_time: 5 };
    let message = [&[0, 1, 0, 0], &2.5_f64.to_le_bytes()[..]].concat();
    writer.write_to_known_channel(&header, &message).unwrap();
    writer.finish().unwrap();
}

#[test]
fn the_same_without_chunks_or_a_summary() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("plain.mcap");
    let plain = || WriteOptions::new().compression(None);
    for options in [
        plain(),
        plain().use_chunks(false),
        plain().emit_summary_records(false).emit_summary_offsets(false),
        plain().calculate_chunk_crcs(false),
        plain().disable_seeking(true),
    ] {
        of_another_tool(options, &file, Some("0 float64 other.x\n"));
        let read = cosim::observe::read(&file).unwrap();
        assert_eq!((read.time(), read.column("other.x").unwrap()), (&[5e-9][..], &[2.5][..]));
    }
}

#[test]
fn what_is_of_other_tools_is_reported() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("other.mcap");
    let reported = |parts: &[&str]| {
        let error = cosim::observe::read(&file).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{parts:?} in {error}");
    };
    let plain = || WriteOptions::new().compression(None);
    of_another_tool(plain(), &file, None);
    reported(&["other.mcap", "/other", "not written by cosim", "cosim.columns"]);
    of_another_tool(plain(), &file, Some("0 float32 other.x\n"));
    reported(&["/other", "lists no columns"]);
    of_another_tool(plain(), &file, Some("0 float64 other.x\n1 float64 other.y\n"));
    reported(&["too short"]);
    // Compressed as in other tools: after the times, size and checksum of the chunk.
    for compression in ["zstd", "lz4"] {
        let (_, whole) = results(&folder);
        let bytes = std::fs::read(whole).unwrap();
        let chunk = 8 + 9 + bytes[9] as usize;
        let (before, after) = bytes.split_at(chunk + 9 + 28);
        let mut compressed = before.to_vec();
        compressed[chunk + 1] += compression.len() as u8;
        compressed.extend((compression.len() as u32).to_le_bytes());
        compressed.extend(compression.bytes());
        compressed.extend(&after[4..]);
        std::fs::write(&file, compressed).unwrap();
        reported(&["other.mcap", compression, "mcap decompress"]);
    }
}
