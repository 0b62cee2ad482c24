//! When something is wrong in a run, for reports.

use super::{Action, Scenario};
use crate::fault::Window;
use crate::observe::Recording;

impl Scenario {
    /// The times in which faults and events act in a run of this scenario that was recorded.
    pub fn windows(&self, recording: &Recording) -> Vec<Window> {
        let faults = self.faults.iter().zip(0..);
        let windows = faults.filter_map(|(fault, n)| fault.window(self.seed, n, recording));
        let mut windows: Vec<Window> = windows.collect();
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
