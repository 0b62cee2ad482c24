//! When faults act in a run, for reports.

use super::{Action, Scenario};
use crate::fault::{Begin, Fault, Kind, Window};
use crate::observe::Recording;

impl Scenario {
    /// The time spans in which faults and events act in a recorded run of this scenario.
    pub fn windows(&self, recording: &Recording) -> Vec<Window> {
        let acting = self.acting(self.seed, recording).into_iter();
        let mut windows: Vec<Window> = acting.map(|(_, window)| window).collect();
        for event in &self.events {
            let at = event.time.seconds();
            if let Action::Reset(name) = &event.what {
                let of_it = |window: &&mut Window| {
                    window.until.is_none() && window.label.ends_with(&format!(" of {name}"))
                };
                windows.iter_mut().filter(of_it).for_each(|window| window.until = Some(at));
            }
            let label = words(&event.what);
            windows.extend(label.map(|label| Window { label, from: at, until: None }));
        }
        windows
    }

    /// The faults with the time spans in which they act, by the random numbers of a seed.
    fn acting(&self, seed: u64, recording: &Recording) -> Vec<(&Fault, Window)> {
        let mut acting: Vec<(&Fault, Window)> = Vec::new();
        for (fault, number) in self.faults.iter().zip(0..) {
            let Some(window) = fault.window(seed, number, recording) else { continue };
            if fault.kind != Kind::Release {
                acting.push((fault, window));
                continue;
            }
            // It ends earlier faults on the same variables.
            for (before, span) in &mut acting {
                if before.variables.iter().any(|name| fault.variables.contains(name)) {
                    let until = span.until.map_or(window.from, |until| until.min(window.from));
                    span.until = Some(until.max(span.from));
                }
            }
        }
        acting
    }

    /// How long drop-outs act between two instants of a run (s), by the random numbers of a seed;
    /// NaN if that depends on what happens in the run. Drop-outs that alternate do not count.
    pub fn outage(&self, seed: u64, [start, stop]: [f64; 2]) -> f64 {
        let silent = |fault: &Fault| matches!(fault.kind, Kind::DropOut { turns: None, .. });
        let matters = |fault: &&Fault| silent(fault) || fault.kind == Kind::Release;
        if self.faults.iter().filter(matters).any(|f| matches!(f.begin, Begin::When(_))) {
            return f64::NAN;
        }
        let ends = self.events.iter().filter(|event| matches!(event.what, Action::End));
        let stop = ends.map(|event| event.time.seconds()).fold(stop, f64::min);
        let run = Recording::from_columns(Vec::new(), vec![start, stop], Vec::new());
        let outages = self.acting(seed, &run).into_iter().filter(|(fault, _)| silent(fault));
        let spans = outages.map(|(_, window)| [window.from, window.until.unwrap_or(stop)]);
        let mut spans: Vec<[f64; 2]> = spans.collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut length, mut end) = (0.0, start);
        for [from, until] in spans {
            length += (until.min(stop) - from.max(end)).max(0.0);
            end = end.max(until);
        }
        length
    }

    /// The faults and events with the variables on which they act, without times.
    pub fn words(&self) -> impl Iterator<Item = String> {
        let events = self.events.iter().filter_map(|event| words(&event.what));
        self.faults.iter().map(Fault::words).chain(events)
    }
}

/// What an event that acts from then on does.
fn words(what: &Action) -> Option<String> {
    match what {
        Action::Override(name, _) => Some(format!("override of {name}")),
        Action::Bias(name, _) => Some(format!("bias of {name}")),
        Action::Reset(_) | Action::End => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_release_ends_the_faults_before_it() {
        let text = "[[fault]]\nkind = 'bias'\non = 'a.x'\nvalue = 1\nfrom = 1\n\
                    [[fault]]\nkind = 'stuck'\non = 'a.y'\nfrom = 1\n\
                    [[fault]]\nkind = 'release'\non = 'a.x'\nfrom = 3\n";
        let scenario = super::super::faults::parse(text, std::path::Path::new("s.toml")).unwrap();
        let recording = Recording::from_columns(Vec::new(), vec![0.0, 5.0], Vec::new());
        let found = scenario.windows(&recording);
        let ends: Vec<Option<f64>> = found.iter().map(|window| window.until).collect();
        assert_eq!(ends, [Some(3.0), None]);
    }

    #[test]
    fn an_outage_is_the_time_without_measurements() {
        let outage = |text: &str| {
            let scenario = super::super::faults::parse(text, std::path::Path::new("s.toml"));
            scenario.unwrap().outage(7, [0.0, 100.0])
        };
        let drop_out =
            |on: &str, when: &str| format!("[[fault]]\nkind = 'drop-out'\non = '{on}'\n{when}\n");
        assert_eq!(outage(""), 0.0);
        assert_eq!(outage(&drop_out("a.x", "from = 10\nfor = 20")), 20.0);
        assert_eq!(
            outage(&("end = 15\n".to_owned() + &drop_out("a.x", "from = 10\nfor = 20"))),
            5.0
        );
        // Until the end, and while another one acts.
        assert_eq!(outage(&drop_out("a.x", "from = 90\nfor = 20")), 10.0);
        let both = drop_out("a.x", "from = 10\nfor = 20") + &drop_out("b.x", "from = 20\nfor = 20");
        assert_eq!(outage(&both), 30.0);
        let released =
            drop_out("a.x", "from = 10") + "[[fault]]\nkind = 'release'\non = 'a.x'\nfrom = 25\n";
        assert_eq!(outage(&released), 15.0);
        assert_eq!(outage(&drop_out("a.x", "up = 5\ndown = 1")), 0.0);
        assert_eq!(outage("[[fault]]\nkind = 'stuck'\non = 'a.x'\nfrom = 10\n"), 0.0);
        assert!(outage(&drop_out("a.x", "when = 'b.y > 1'\nfor = 5")).is_nan());
    }

    #[test]
    fn events_act_until_they_are_reset() {
        let text = r#"{"defaults": {"model": "a", "variable": "x"}, "events": [
            {"time": 1, "action": "override", "value": 2}, {"time": 3, "action": "reset"},
            {"time": 4, "action": "bias", "value": 1}]}"#;
        let scenario = super::super::osp::parse(text, std::path::Path::new("s.json")).unwrap();
        let found = scenario.windows(&Recording::new());
        let window =
            |word: &str, from, until| Window { label: format!("{word} of a.x"), from, until };
        assert_eq!(found, [window("override", 1.0, Some(3.0)), window("bias", 4.0, None)]);
        assert_eq!(scenario.words().collect::<Vec<_>>(), ["override of a.x", "bias of a.x"]);
    }
}
