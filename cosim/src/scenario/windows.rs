//! When faults act in a run, for reports.

use super::{Action, Scenario};
use crate::fault::{Kind, Window};
use crate::observe::Recording;

impl Scenario {
    /// The time spans in which faults and events act in a recorded run of this scenario.
    pub fn windows(&self, recording: &Recording) -> Vec<Window> {
        let mut windows: Vec<Window> = Vec::new();
        let mut acting: Vec<&[String]> = Vec::new();
        for (fault, number) in self.faults.iter().zip(0..) {
            let Some(window) = fault.window(self.seed, number, recording) else { continue };
            if fault.kind != Kind::Release {
                acting.push(&fault.variables);
                windows.push(window);
                continue;
            }
            // It ends earlier faults on the same variables.
            for (before, variables) in windows.iter_mut().zip(&acting) {
                if variables.iter().any(|name| fault.variables.contains(name)) {
                    let until = before.until.map_or(window.from, |until| until.min(window.from));
                    before.until = Some(until.max(before.from));
                }
            }
        }
        for event in &self.events {
            let at = event.time.seconds();
            let (word, name) = match &event.what {
                Action::Override(name, _) => ("override", name),
                Action::Bias(name, _) => ("bias", name),
                Action::Reset(name) => {
                    let of_it = |window: &&mut Window| {
                        window.until.is_none() && window.label.ends_with(&format!(" of {name}"))
                    };
                    windows.iter_mut().filter(of_it).for_each(|window| window.until = Some(at));
                    continue;
                }
                Action::End => continue,
            };
            windows.push(Window { label: format!("{word} of {name}"), from: at, until: None });
        }
        windows
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
    fn events_act_until_they_are_reset() {
        let text = r#"{"defaults": {"model": "a", "variable": "x"}, "events": [
            {"time": 1, "action": "override", "value": 2}, {"time": 3, "action": "reset"},
            {"time": 4, "action": "bias", "value": 1}]}"#;
        let scenario = super::super::parse(text, std::path::Path::new("s.json")).unwrap();
        let found = scenario.windows(&Recording::new());
        let window =
            |word: &str, from, until| Window { label: format!("{word} of a.x"), from, until };
        assert_eq!(found, [window("override", 1.0, Some(3.0)), window("bias", 4.0, None)]);
    }
}
