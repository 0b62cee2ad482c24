//! Seeds of the readers' fuzz targets: complete valid files, because no fuzzer finds an archive or
//! a system description from nothing.

use crate::paths;
use anyhow::{Context, Result};
use cosim::{Overrides, Run, System, observe};
use std::{fs, path::Path};

#[path = "../../../cosim/fuzz/samples.rs"]
#[allow(dead_code, unreachable_pub, reason = "the fuzz targets need all of it")]
mod samples;

/// Writes the seeds of a target of `cosim/fuzz` no longer than `longest` (bytes) into `folder`.
pub(super) fn write(target: &str, longest: usize, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let seeds = of(target)?.into_iter().filter(|seed| seed.len() <= longest);
    for (number, seed) in seeds.enumerate() {
        let file = folder.join(format!("good_{number}"));
        fs::write(&file, seed).with_context(|| file.display().to_string())?;
    }
    Ok(())
}

fn of(target: &str) -> Result<Vec<Vec<u8>>> {
    let committed = |folder: &str, ending: &str| committed(&paths::root().join(folder), ending);
    let packed = |name: &str, files: Vec<Vec<u8>>| -> Vec<Vec<u8>> {
        files.iter().map(|file| samples::zip(&[(name, file)])).collect()
    };
    let fuzz = paths::target().join("fuzz");
    Ok(match target {
        "archive" => {
            let described = packed("modelDescription.xml", committed("modelDescription", "xml")?);
            [vec![samples::fmu(), samples::package()], described].concat()
        }
        "description" => {
            let own = samples::DESCRIPTION.into();
            [vec![own], committed("modelDescription", "xml")?].concat()
        }
        "ssd" => [vec![samples::SYSTEM.into()], committed("examples", "ssd")?].concat(),
        "ssp" => {
            let examples = packed("SystemStructure.ssd", committed("examples", "ssd")?);
            [vec![samples::package()], examples].concat()
        }
        "ssv" => vec![samples::PARAMETERS.into()],
        "ssm" => vec![samples::MAPPING.into()],
        "ssb" => vec![samples::DICTIONARY.into()],
        "osp" => vec![samples::structure()],
        "scenario" => {
            let own = samples::FAULTS.into();
            let faults = committed("examples/campaign/faults", "toml")?;
            [vec![own], committed("examples", "json")?, faults].concat()
        }
        "campaign" => committed("examples/campaign", "toml")?,
        "roles" => vec![samples::ROLES.into()],
        "csv" => [vec![samples::TABLE.into()], committed("examples", "csv")?].concat(),
        "mcap" => vec![results("mcap")?],
        "parquet" => vec![results("parquet")?],
        "snapshot" => vec![samples::state_of_functions(&fuzz)],
        "manifest" => vec![samples::REMOTE.into(), samples::CLASS.into()],
        "frame" => samples::frames(),
        "exported" => vec![samples::INTERFACE.into()],
        "kept" => vec![samples::state_of_hosted(&fuzz)],
        "message" => vec![samples::step()],
        _ => Vec::new(),
    })
}

/// The files of a folder with this ending, in the order of their names.
fn committed(folder: &Path, ending: &str) -> Result<Vec<Vec<u8>>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut files = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    files.retain(|file| file.extension().is_some_and(|own| own == ending));
    files.sort();
    files.iter().map(|file| fs::read(file).with_context(|| file.display().to_string())).collect()
}

/// Results of a GPS that runs for three seconds.
fn results(ending: &str) -> Result<Vec<u8>> {
    let results = paths::target().join("fuzz").join("run").with_extension(ending);
    let overrides = Overrides::new().stop_time(3.0);
    let system = System::single(&paths::fmus().join("Gps.fmu"), &overrides, None)?;
    let mut observer = observe::create(&results)?;
    Run::new(&system).observe(&mut *observer).go()?;
    Ok(fs::read(&results)?)
}
