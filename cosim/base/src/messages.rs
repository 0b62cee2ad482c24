//! Lists of messages about a file: it can give reason for millions.

/// The first messages, and how many more there were.
#[derive(Debug, Clone, Default)]
pub struct Messages<const KEPT: usize> {
    first: Vec<String>,
    more: usize,
}

/// The warnings about a system.
pub type Warnings = Messages<1000>;

impl<const KEPT: usize> Messages<KEPT> {
    /// Adds a message.
    pub fn push(&mut self, message: String) {
        if self.first.len() < KEPT {
            self.first.push(message);
        } else {
            self.more += 1;
        }
    }

    /// The messages that are reported.
    pub fn into_vec(self) -> Vec<String> {
        let more = (self.more > 0).then(|| format!("and {} more warnings", self.more));
        self.first.into_iter().chain(more).collect()
    }
}

impl<const KEPT: usize> Extend<String> for Messages<KEPT> {
    fn extend<T: IntoIterator<Item = String>>(&mut self, messages: T) {
        messages.into_iter().for_each(|message| self.push(message));
    }
}
