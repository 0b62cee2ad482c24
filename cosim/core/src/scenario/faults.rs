//! Reads faults from a TOML file.

use std::path::Path;

use super::{Action, Event, Scenario};
use crate::fault::{Begin, End, Fault, KINDS, Kind, Meanwhile, Spread, Word};
use crate::table::{Document, Entry, Table};
use cosim_base::error::{Code, Result};
use cosim_base::names;
use cosim_base::time::Time;

/// Keys that every fault accepts.
const COMMON: [&str; 10] =
    ["kind", "on", "installed", "from", "until", "for", "between", "when", "ramp-in", "ramp-out"];

pub(super) fn parse(text: &str, file: &Path) -> Result<Scenario> {
    let document = Document::new(text, file, Code::Scenario);
    let parsed = document.parse()?;
    let root = document.root(&parsed);
    root.allow(&["description", "seed", "end", "fault"]);
    root.text("description");
    let faults = root.tables("fault").iter().filter_map(fault).collect();
    let end = root.time("end").map(|time| Event { time, what: Action::End });
    let seed = root.count("seed").unwrap_or(0);
    document.finish()?;
    Ok(Scenario::new(end.into_iter().collect(), faults, seed))
}

fn fault(table: &Table<'_>) -> Option<Fault> {
    let name = table.needed_text("kind");
    let word = name.and_then(|name| {
        let word = KINDS.iter().find(|word| word.name == name);
        if word.is_none() {
            let all = || KINDS.iter().map(|word| word.name);
            let help = names::did_you_mean(name, all())
                .unwrap_or_else(|| format!("known are {}", all().collect::<Vec<_>>().join(", ")));
            table.get("kind")?.wrong(format!("there is no fault '{name}'; {help}"));
        }
        word
    });
    if let Some(word) = word {
        let own = word.keys.iter().map(|meant| meant.key);
        table.allow(&COMMON.into_iter().chain(own).collect::<Vec<_>>());
    }
    let variables: Vec<String> = table.texts("on").into_iter().map(str::to_owned).collect();
    if variables.is_empty() {
        table.wrong("'on' is missing: the variables that the fault acts on");
    }
    let (begin, end) = (begin(table), end(table));
    if let (Some(Begin::At(from)), Some(End::At(until))) = (&begin, end)
        && until <= *from
    {
        table.wrong(format!("it ends at {until}, but begins at {from}"));
    }
    let installed = table.time("installed");
    if let (Some(Begin::At(from)), Some(installed)) = (&begin, installed)
        && *from < installed
    {
        table.wrong(format!("it begins at {from}, but is installed at {installed}"));
    }
    let ramp = |key: &str| duration(table, key).unwrap_or(Time::ZERO);
    Some(Fault {
        variables,
        kind: kind(table, word?)?,
        installed,
        begin: begin?,
        end: end?,
        ramp_in: ramp("ramp-in"),
        ramp_out: ramp("ramp-out"),
        every: duration(table, "every").unwrap_or(Time::ZERO),
    })
}

/// `None` if that is wrong.
fn begin(table: &Table<'_>) -> Option<Begin> {
    let given = ["from", "between", "when"].into_iter().filter(|key| table.get(key).is_some());
    let given: Vec<&str> = given.collect();
    match given[..] {
        [] => Some(Begin::Start),
        ["from"] => table.time("from").map(Begin::At),
        ["between"] => {
            let (first, last) = two(&table.get("between")?, "instants")?;
            Some(Begin::Between(first, last))
        }
        ["when"] => match table.text("when")?.parse() {
            Ok(condition) => Some(Begin::When(condition)),
            Err(what) => {
                let what: String = what;
                table.get("when")?.wrong(what);
                None
            }
        },
        _ => {
            table.wrong(format!("only one of {} can define when it begins", given.join(", ")));
            None
        }
    }
}

/// `None` if that is wrong.
fn end(table: &Table<'_>) -> Option<End> {
    match (table.get("until"), table.get("for")) {
        (None, None) => Some(End::Never),
        (Some(_), None) => table.time("until").map(End::At),
        (None, Some(_))
            if ["from", "between", "when"].iter().all(|key| table.get(key).is_none()) =>
        {
            table.wrong("'for' needs a start; use 'until' to set an end");
            None
        }
        (None, Some(entry)) if entry.is_list() => {
            let (least, most) = two(&entry, "durations")?;
            if least <= Time::ZERO {
                entry.wrong(format!("{least} is not greater than 0"));
                return None;
            }
            Some(End::AfterBetween(least, most))
        }
        (None, Some(_)) => duration(table, "for").map(End::After),
        (Some(_), Some(_)) => {
            table.wrong("'until' and 'for' exclude each other");
            None
        }
    }
}

/// A list of two times that do not decrease.
fn two(entry: &Entry<'_>, what: &str) -> Option<(Time, Time)> {
    let numbers = entry.list().iter().map(|part| part.number()).collect::<Option<Vec<_>>>();
    let [first, last] = numbers?[..] else {
        entry.wrong(format!("a list of two {what} is expected"));
        return None;
    };
    if last < first {
        entry.wrong(format!("{last} is less than {first}"));
        return None;
    }
    Some((entry.seconds(first)?, entry.seconds(last)?))
}

fn duration(table: &Table<'_>, key: &str) -> Option<Time> {
    table.positive(key).and(table.time(key))
}

fn kind(table: &Table<'_>, word: &Word) -> Option<Kind> {
    let number = |key: &str| table.needed_number(key);
    let positive = |key: &str| table.needed_positive(key);
    Some(match word.name {
        "override" => Kind::Override(number("value")?),
        "bias" => Kind::Bias(number("value")?),
        "scale" => Kind::Scale(number("factor")?),
        "drift" => Kind::Drift(number("rate")?),
        "ramp" => {
            let (size, over) = (number("value"), positive("over"));
            Kind::Ramp { size: size?, over: over? }
        }
        "white-noise" => Kind::WhiteNoise(positive("sigma")?),
        "gauss-markov" => {
            let (sigma, tau) = (positive("sigma"), positive("tau"));
            Kind::GaussMarkov { sigma: sigma?, tau: tau? }
        }
        "outliers" => outliers(table)?,
        "stuck" => Kind::Stuck,
        "zero" => Kind::Override(0.0),
        "nan" => Kind::NotANumber,
        "quantization" => Kind::Quantization(positive("step")?),
        "saturation" => {
            let (low, high) = (number("min"), number("max"));
            if low? > high? {
                table.wrong("'min' is above 'max'");
            }
            Kind::Saturation(low?, high?)
        }
        "drop-out" => drop_out(table)?,
        "latency" => {
            let jitter = table.get("jitter").map_or(Some(0.0), |_| table.positive("jitter"));
            let delay = number("delay")?;
            if delay < 0.0 {
                table.get("delay")?.wrong(format!("{delay} is negative"));
            }
            Kind::Latency { delay, jitter: jitter? }
        }
        "lag" => Kind::Lag(positive("tau")?),
        "rate-change" => {
            positive("every")?;
            Kind::Sampling
        }
        "reordering" | "duplicates" => {
            let (share, delay) = (probability(table, "share"), positive("delay"));
            Kind::Reordering { share: share?, delay: delay?, again: word.name == "duplicates" }
        }
        "release" => Kind::Release,
        "reset" => {
            if let Some(entry) = ["until", "for"].iter().find_map(|key| table.get(key)) {
                entry.wrong("a reset has no duration");
            }
            if ["from", "between", "when"].iter().all(|key| table.get(key).is_none()) {
                table.wrong("'from', 'between' or 'when' must define when the reset happens");
            }
            Kind::Reset
        }
        _ => return None,
    })
}

fn probability(table: &Table<'_>, key: &str) -> Option<f64> {
    let share = table.needed_positive(key)?;
    if share > 1.0 {
        table.get(key)?.wrong("a probability is at most 1");
    }
    Some(share)
}

fn outliers(table: &Table<'_>) -> Option<Kind> {
    let share = probability(table, "share");
    let size = match (table.get("sigma"), table.get("size")) {
        (Some(_), None) => Spread::Normal(table.positive("sigma")?),
        (None, Some(_)) => Spread::Uniform(table.positive("size")?),
        _ => {
            table.wrong("either 'sigma' or 'size' must define how large they are");
            return None;
        }
    };
    Some(Kind::Outliers { share: share?, size })
}

fn drop_out(table: &Table<'_>) -> Option<Kind> {
    let turns = match (table.get("up"), table.get("down")) {
        (None, None) => None,
        _ => {
            let (up, down) = (table.needed_positive("up"), table.needed_positive("down"));
            Some((up?, down?))
        }
    };
    let meanwhile = match table.text("meanwhile") {
        None | Some("last") => Meanwhile::Last,
        Some("zero") => Meanwhile::Zero,
        Some("nan") => Meanwhile::NotANumber,
        Some(other) => {
            let entry = table.get("meanwhile")?;
            entry.wrong(format!("'{other}' is not one of last, zero, nan"));
            return None;
        }
    };
    Some(Kind::DropOut { turns, meanwhile })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Scenario> {
        parse(text, Path::new("s.toml"))
    }

    #[test]
    fn every_kind_is_read_as_its_example_says() {
        for word in &KINDS {
            let text = format!(
                "[[fault]]\nkind = \"{}\"\non = \"a.x\"\nfrom = 1\n{}",
                word.name, word.example
            );
            let scenario = read(&text).unwrap_or_else(|e| panic!("{text}\n{e}"));
            assert_eq!(scenario.faults.len(), 1);
            for meant in word.keys {
                let named = word.example.contains(&format!("{} =", meant.key));
                assert!(named || ["size", "meanwhile"].contains(&meant.key), "{}", meant.key);
            }
        }
    }

    #[test]
    fn every_mistake_is_reported_with_its_line_and_a_typo_with_the_nearest_key() {
        let text = "sed = 1\n[[fault]]\nkind = \"wite-noise\"\non = \"a.x\"\n\n[[fault]]\n\
                    kind = \"white-noise\"\nsigma = 0\nfron = 2\n\n[[fault]]\nkind = \"stuck\"\n\
                    on = \"a.x\"\nfrom = 5\nuntil = 4\n[[fault]]\nkind = \"ramp\"\non = \"b.y\"\n\
                    value = \"much\"\nwhen = \"b.y\"\n";
        let error = read(text).unwrap_err();
        let found: Vec<(usize, &str)> =
            error.problems().map(|p| (p.place().unwrap().1.unwrap(), p.what())).collect();
        for (line, part) in [
            (1, "did you mean 'seed'"),
            (3, "did you mean 'white-noise'"),
            (9, "'fron' is unknown; did you mean 'from'"),
            (6, "'on' is missing"),
            (8, "0 is not greater than 0"),
            (11, "it ends at 4"),
            (19, "not a number but a string"),
            (16, "'over' is missing"),
            (20, "has no comparison"),
        ] {
            let named = |(at, what): &(usize, &str)| *at == line && what.contains(part);
            assert!(found.iter().any(named), "{line} {part}: {found:#?}");
        }
        assert_eq!(found.len(), 9, "{found:#?}");
        for (wrong, said) in [
            ("for = [20]", "a list of two durations is expected"),
            ("for = [20, 10]", "10 is less than 20"),
            ("for = [0, 10]", "0 s is not greater than 0"),
        ] {
            let text = format!("[[fault]]\nkind = 'stuck'\non = 'a.x'\nfrom = 1\n{wrong}\n");
            let error = read(&text).unwrap_err().to_string();
            assert!(error.contains(said) && error.contains("s.toml:5"), "{error}");
        }
        assert!(read("x = ").unwrap_err().to_string().contains("s.toml:1"));
    }
}
