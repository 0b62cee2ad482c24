//! `cargo xtask mutants`: deliberate faults in the navigation filters, one at a time, in a copy of
//! the package. A test that CI runs has to catch each of them; one that survives is a gap in the
//! tests.
//!
//! A mutant names its source text, which must occur exactly once, so the table cannot go out of
//! date.

use crate::{paths, process};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A fault: in `file` below `src/estimation`, `old` becomes `new`; `test` (module, name) catches it.
struct Mutant {
    name: &'static str,
    file: &'static str,
    old: &'static str,
    new: &'static str,
    test: (&'static str, &'static str),
}

/// Tests that catch mutants.
mod by {
    type Test = (&'static str, &'static str);
    pub(super) const BOUND: Test = ("navigation", "covariances_are_those_of_the_bound");
    pub(super) const ARITHMETIC: Test = ("navigation", "without_noise_there_is_no_error");
    pub(super) const NIS: Test = ("navigation", "innovations_are_as_large_as_predicted");
    pub(super) const NEES: Test = ("navigation", "normalised_errors_are_those_of_chance");
    pub(super) const HEAVE: Test =
        ("navigation", "the_heave_of_the_dynamic_filter_solves_its_riccati_equation");
    pub(super) const SOUTH: Test = ("navigation", "a_heading_along_south_is_as_good_as_any");
    pub(super) const OUTAGE: Test =
        ("navigation_faults", "without_fix_and_velocity_log_the_model_aided_filter_is_the_best");
    pub(super) const OUTLIERS: Test = ("navigation_faults", "outliers_have_a_bounded_influence");
    pub(super) const LATE: Test = ("navigation_faults", "late_fixes_are_as_good_as_fixes_in_time");
    pub(super) const COMPASS: Test = ("navigation_faults", "the_bias_of_a_compass_is_found");
    pub(super) const PROPELLER: Test =
        ("navigation_faults", "a_lost_propeller_is_found_within_seconds");
}

/// Those tests, and what they share. The others are not built.
const MODULES: [&str; 6] =
    ["mission", "navigation", "navigation_faults", "scoring", "statistics", "trial"];

const INERTIAL: &str = "process/inertial.rs";
const DYNAMIC: &str = "process/planar_dynamic.rs";
const AID: &str = "process/model_aid.rs";

#[rustfmt::skip]
const MUTANTS: &[Mutant] = &[
    // Jacobians.
    Mutant { name: "inertial: sign of du/dtheta", file: INERTIAL, test: by::BOUND,
        old: "(THETA, back * skew(", new: "(THETA, -back * skew(" },
    Mutant { name: "inertial: sign of du/db_a", file: INERTIAL, test: by::BOUND,
        old: "(B_A, -half_turn.transpose() * dt)", new: "(B_A, half_turn.transpose() * dt)" },
    Mutant { name: "inertial: sign of dtheta/db_g", file: INERTIAL, test: by::BOUND,
        old: "(B_G, -jacobian)", new: "(B_G, jacobian)" },
    Mutant { name: "inertial: sign of dp/dtheta", file: INERTIAL, test: by::BOUND,
        old: "(THETA, -r * skew(", new: "(THETA, r * skew(" },
    Mutant { name: "dynamic: sign of the Munk moment's dr'/dv", file: DYNAMIC, test: by::OUTAGE,
        old: "-self.munk * nu.x / m6", new: "self.munk * nu.x / m6" },
    Mutant { name: "dynamic: sign of the Munk moment", file: DYNAMIC, test: by::OUTAGE,
        old: "-self.munk * nu.x * nu.y,", new: "self.munk * nu.x * nu.y," },
    Mutant { name: "dynamic: sign of dx'/dpsi", file: DYNAMIC, test: by::COMPASS,
        old: "j[0][PSI] = -velocity.y;", new: "j[0][PSI] = velocity.y;" },
    Mutant { name: "aid: sign of the force balance's dF/dv", file: AID, test: by::NEES,
        old: "- slope) + skew(w);", new: "+ slope) - skew(w);" },
    Mutant { name: "aid: sign of the force balance by the vertical", file: AID, test: by::BOUND,
        old: "excess_weight - Matrix3::identity() * self.gravity", new: "excess_weight + Matrix3::identity() * self.gravity" },
    Mutant { name: "aid: sign of the Munk moment's derivative", file: AID, test: by::OUTAGE,
        old: "RowVector3::new(nu.y, -nu.x, 0.0)", new: "RowVector3::new(-nu.y, nu.x, 0.0)" },
    // Lever arms.
    Mutant { name: "lever arm of the velocity log left out", file: "sensor/dvl.rs", test: by::NIS,
        old: "motion.velocity.value + lever - ", new: "motion.velocity.value - " },
    Mutant { name: "lever arm of the depth left out", file: "sensor/depth.rs", test: by::ARITHMETIC,
        old: "motion.point(&self.lever)", new: "motion.point(&Vector3::zeros())" },
    // Noise figures.
    Mutant { name: "velocity log: noise doubled", file: "track.rs", test: by::BOUND,
        old: "sigma: s.dvl_sigma }", new: "sigma: 2.0 * s.dvl_sigma }" },
    Mutant { name: "velocity log: noise halved", file: "track.rs", test: by::NIS,
        old: "sigma: s.dvl_sigma }", new: "sigma: 0.5 * s.dvl_sigma }" },
    Mutant { name: "fix: noise doubled", file: "track.rs", test: by::BOUND,
        old: "sigma: s.fix_sigma }", new: "sigma: 2.0 * s.fix_sigma }" },
    Mutant { name: "fix: noise halved", file: "track.rs", test: by::NIS,
        old: "sigma: s.fix_sigma }", new: "sigma: 0.5 * s.fix_sigma }" },
    Mutant { name: "heading: noise doubled", file: "track.rs", test: by::BOUND,
        old: "sigma: s.heading_sigma }", new: "sigma: 2.0 * s.heading_sigma }" },
    Mutant { name: "heading: noise halved", file: "track.rs", test: by::NIS,
        old: "sigma: s.heading_sigma }", new: "sigma: 0.5 * s.heading_sigma }" },
    Mutant { name: "tilt: noise doubled", file: "track.rs", test: by::NIS,
        old: "sigma: s.tilt_sigma }", new: "sigma: 2.0 * s.tilt_sigma }" },
    Mutant { name: "depth: noise doubled", file: "track.rs", test: by::NIS,
        old: "sigma: s.depth_sigma }", new: "sigma: 2.0 * s.depth_sigma }" },
    Mutant { name: "depth: noise halved", file: "track.rs", test: by::BOUND,
        old: "sigma: s.depth_sigma }", new: "sigma: 0.5 * s.depth_sigma }" },
    Mutant { name: "inertial: gyro noise doubled", file: INERTIAL, test: by::BOUND,
        old: "true => (p.sensors.accelerometer.noise_density, p.sensors.gyro.noise_density)",
        new: "true => (p.sensors.accelerometer.noise_density, 2.0 * p.sensors.gyro.noise_density)" },
    Mutant { name: "inertial: accelerometer noise halved", file: INERTIAL, test: by::BOUND,
        old: "true => (p.sensors.accelerometer.noise_density, p.sensors.gyro.noise_density)",
        new: "true => (0.5 * p.sensors.accelerometer.noise_density, p.sensors.gyro.noise_density)" },
    Mutant { name: "dynamic: gyro noise doubled", file: DYNAMIC, test: by::NEES,
        old: "let density = self.parameters.sensors.gyro.noise_density;",
        new: "let density = 2.0 * self.parameters.sensors.gyro.noise_density;" },
    Mutant { name: "dynamic: gyro noise halved", file: DYNAMIC, test: by::NEES,
        old: "let density = self.parameters.sensors.gyro.noise_density;",
        new: "let density = 0.5 * self.parameters.sensors.gyro.noise_density;" },
    Mutant { name: "aid: accelerometer noise doubled", file: AID, test: by::BOUND,
        old: "variance(p.sensors.accelerometer.noise_density)", new: "variance(2.0 * p.sensors.accelerometer.noise_density)" },
    Mutant { name: "aid: accelerometer noise halved", file: AID, test: by::BOUND,
        old: "variance(p.sensors.accelerometer.noise_density)", new: "variance(0.5 * p.sensors.accelerometer.noise_density)" },
    Mutant { name: "aid: gyro noise halved", file: AID, test: by::BOUND,
        old: "variance(p.sensors.gyro.noise_density)", new: "variance(0.5 * p.sensors.gyro.noise_density)" },
    // Process noise.
    Mutant { name: "inertial: no noise of the velocity", file: INERTIAL, test: by::BOUND,
        old: "belief.add_noise(U + i, q);", new: "" },
    Mutant { name: "dynamic: no white force", file: DYNAMIC, test: by::HEAVE,
        old: "belief.add_noise(U + axis, square(white) * half);", new: "let _ = white;" },
    Mutant { name: "aid: noise of an interval not renewed", file: AID, test: by::BOUND,
        old: "(0..3).for_each(|i| f.scale(at.force_noise + i, 0.0));", new: "" },
    Mutant { name: "aid: the gyro's noise of an interval not renewed", file: AID, test: by::BOUND,
        old: "f.scale(at.rate_noise, 0.0);", new: "" },
    Mutant { name: "aid: the gyro's noise before not kept", file: AID, test: by::ARITHMETIC,
        old: "[(at.rate_noise, 1.0)]", new: "[(at.rate_noise, 0.0)]" },
    // Time.
    Mutant { name: "inertial samples held instead of joined", file: "interval.rs", test: by::ARITHMETIC,
        old: "self.integral[i] += 0.5 * h * (a[i] + b[i]);", new: "self.integral[i] += h * a[i];" },
    Mutant { name: "stamps ignored", file: "intake.rs", test: by::LATE,
        old: "if stamped { self.anchor(now, stamp, latency) } else { now }", new: "{ let _ = latency; now }" },
    Mutant { name: "measurements fused twice", file: "track.rs", test: by::BOUND,
        old: "let correction = absorb(&mut self.belief, &observation, &mut verdict, &mut witness);",
        new: "let correction = absorb(&mut self.belief, &observation, &mut verdict, &mut witness);\n        let _ = fuse(&mut self.belief, &observation, gate, &mut witness);" },
    // Angles, outliers, biases, losses.
    Mutant { name: "heading not wrapped", file: "sensor/ahrs.rs", test: by::SOUTH,
        old: "wrap(value[2] - predicted)", new: "value[2] - predicted" },
    Mutant { name: "gate off", file: "track.rs", test: by::OUTLIERS,
        old: "if setup.parameters.gated { GATE[", new: "if !setup.parameters.gated { GATE[" },
    Mutant { name: "compass: sign of the bias", file: "sensor/ahrs.rs", test: by::COMPASS,
        old: "heading(&motion.rotation) + motion.optional", new: "heading(&motion.rotation) - motion.optional" },
    Mutant { name: "compass: sign of the bias's derivative", file: "sensor/ahrs.rs", test: by::COMPASS,
        old: "o.rows[0][state] = 1.0;", new: "o.rows[0][state] = -1.0;" },
    Mutant { name: "sign of the gyro's bias", file: INERTIAL, test: by::BOUND,
        old: "rate.set_block(B_G, &-Matrix3::identity());", new: "rate.set_block(B_G, &Matrix3::identity());" },
    Mutant { name: "bank: errors not carried on", file: "monitor.rs", test: by::PROPELLER,
        old: "advance(&mut self.errors, f);", new: "let _ = f;" },
];

/// Tries the mutants whose names contain `filter`, all without one.
pub(crate) fn run(filter: Option<&str>) -> Result<()> {
    let room = copy()?;
    let chosen = MUTANTS.iter().filter(|m| filter.is_none_or(|text| m.name.contains(text)));
    let chosen: Vec<&Mutant> = chosen.collect();
    for mutant in &chosen {
        mutated(mutant)?;
    }
    process::quietly(&mut test(&room, "navigation")).context("without a mutant")?;
    let mut survivors = 0;
    for mutant in &chosen {
        let caught = try_mutant(&room, mutant)?;
        survivors += u32::from(!caught);
        let verdict = if caught { "caught" } else { "SURVIVED" };
        println!("| {} | {verdict} | {}::{} |", mutant.name, mutant.test.0, mutant.test.1);
    }
    ensure!(survivors == 0, "{survivors} of {} mutants survived", chosen.len());
    Ok(())
}

/// The sources with the fault.
fn mutated(mutant: &Mutant) -> Result<String> {
    let path = paths::root().join("src/estimation").join(mutant.file);
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let count = text.matches(mutant.old).count();
    ensure!(count == 1, "{}: `{}` is {count} times in {}", mutant.name, mutant.old, mutant.file);
    Ok(text.replace(mutant.old, mutant.new))
}

fn try_mutant(room: &Path, mutant: &Mutant) -> Result<bool> {
    let path = room.join("src/estimation").join(mutant.file);
    let sound = fs::read_to_string(&path)?;
    fs::write(&path, mutated(mutant)?)?;
    let (module, name) = mutant.test;
    let name = format!("{module}::{name}");
    // A mutant that does not compile would count as caught.
    let built = test(room, &name).arg("--no-run").output()?;
    if !built.status.success() {
        bail!("{} does not compile:\n{}", mutant.name, String::from_utf8_lossy(&built.stderr));
    }
    let outcome = test(room, &name).output()?;
    fs::write(&path, sound)?;
    Ok(!outcome.status.success())
}

/// The tests whose names contain `name`.
fn test(room: &Path, name: &str) -> Command {
    let mut command = process::cargo(&["test", "--release", "--quiet", "--test", "all", name]);
    command.current_dir(room).env("CARGO_TARGET_DIR", room.join("target"));
    // Built many times, run once: only code affected by a fault is rebuilt.
    command.env("CARGO_INCREMENTAL", "1");
    command.args(["--config", "profile.release.package.rexrov.codegen-units=64"]);
    command
}

/// Copies the root package, as a separate workspace, into target/mutants.
fn copy() -> Result<PathBuf> {
    let (root, room) = (paths::root(), paths::target().join("mutants"));
    for folder in ["src", "tests"] {
        let to = room.join(folder);
        if to.exists() {
            fs::remove_dir_all(&to)?;
        }
        copy_folder(&root.join(folder), &to)?;
    }
    fs::write(room.join("tests/all.rs"), MODULES.map(|name| format!("mod {name};\n")).concat())?;
    let manifest = fs::read_to_string(root.join("Cargo.toml"))?;
    let own = manifest.lines().filter(|line| {
        !["exclude = ", "members = ", "default-members = "].iter().any(|key| line.starts_with(key))
    });
    // Crates of the workspace that it uses stay where they are.
    let path = format!("path = \"{}/", root.display());
    let own = own.map(|line| line.replace("path = \"fmu/", &format!("{path}fmu/")));
    fs::write(room.join("Cargo.toml"), own.collect::<Vec<_>>().join("\n"))?;
    fs::copy(root.join("Cargo.lock"), room.join("Cargo.lock"))?;
    // The same versions of fewer packages.
    let mut fewer = process::unlocked(&["update", "--workspace", "--offline", "--quiet"]);
    process::run(fewer.current_dir(&room))?;
    Ok(room)
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_can_still_be_put_into_the_source() {
        for mutant in MUTANTS {
            mutated(mutant).unwrap();
        }
    }

    #[test]
    fn the_copy_is_a_package_that_cargo_can_read() {
        copy().unwrap();
    }
}
