//! Files that a component reads: their locations as importers of each system spell them.

use super::{guid, machine::Machine};
use crate::package::platform::Platform;
use anyhow::{Context, Result};
use std::{fmt::Write, fs, path::Path};

/// A course with Windows line ends.
const COURSE: &str = "0,0\r\n100,0,5 # corner\r\n100,50\r\n";

/// Puts a course where it is hard to find, and a job that reads it by all spellings of its
/// location.
pub(super) fn lay_out(platform: &Platform, machine: &Machine, folder: &Path) -> Result<()> {
    // Longer than the 260 characters that old functions of Windows accept.
    let deep = format!("r\u{e4}ume und 100%/{}", ["abcdefghijklmnopqrstuvwxyz"; 11].join("/"));
    let resources = folder.join(&deep);
    fs::create_dir_all(&resources)?;
    fs::write(resources.join("b\u{f6}gen 1.csv"), COURSE)?;
    let place = resources.to_str().context("the folder's name is no text")?;
    let pursuit = rexrov_fmu::REGISTRY.named("PurePursuit").context("PurePursuit is missing")?;
    let course = pursuit.table().named("course").context("course is missing")?.reference;
    let spellings = match machine {
        // Wine shows the whole file system as a drive.
        Machine::Wine(_) => windows(&format!("Z:{place}")),
        _ => unix(place),
    };
    let mut plan = String::new();
    for spelling in spellings {
        writeln!(plan, "{course}\t{spelling}\tb\u{f6}gen 1.csv")?;
    }
    fs::write(folder.join("locations.plan"), plan)?;
    let jobs = folder.join("jobs.txt");
    let mut text = fs::read_to_string(&jobs)?;
    let library = platform.library("rexrov-fmu");
    let guid = guid("PurePursuit")?;
    writeln!(text, "locations\t./{library}\t{guid}\tlocations.plan\tlocations.txt")?;
    fs::write(&jobs, text)?;
    Ok(())
}

fn unix(path: &str) -> Vec<String> {
    let encoded = encode(path);
    vec![
        path.to_owned(),
        format!("file://{encoded}"),
        format!("file:{encoded}"),
        format!("file:///{encoded}/"),
        format!("FILE://localhost{encoded}"),
        format!("file://{}", path.replace('%', "%25")),
    ]
}

fn windows(path: &str) -> Vec<String> {
    let encoded = encode(path).replacen("Z%3A", "Z:", 1);
    let plain = path.replace('%', "%25");
    vec![
        path.to_owned(),
        path.replace('/', "\\"),
        format!(r"\\?\{}", path.replace('/', "\\")),
        format!("file:///{encoded}"),
        format!("file:/{encoded}"),
        format!("file:{encoded}"),
        format!("file:////{encoded}/"),
        format!("FILE://localhost/{encoded}"),
        format!("file:///{}", encoded.replacen("Z:", "z%3A", 1)),
        format!("file:///{plain}"),
        format!("file:///{}", plain.replace('/', "\\")),
    ]
}

fn encode(path: &str) -> String {
    let mut text = String::new();
    for &byte in path.as_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' => {
                text.push(byte.into());
            }
            _ => text += &format!("%{byte:02X}"),
        }
    }
    text
}
