//! The protocol between the page's script and the server.
//!
//! Texts are JSON with `op`. The server sends `hello`, `state` and `event`; the script sends `show`
//! (which columns it wants), `pause`, `play`, `step`, `speed` and `fault`. Values are sent as
//! binary messages, little-endian: the number of rows, the number of the `show` they answer, 1 if
//! they are the history that replaces everything before, the number of columns (32 bits each); the
//! times; the rows (64-bit floats).

use serde_json::{Map, Value, json};
use tungstenite::Message;

use super::batch::Batch;
use super::client::Speaker;
use super::hub::{About, Hub, Newest, Request, SPEEDS, locked};
use cosim_core::scenario::KINDS;
use cosim_results::roles::{Axes, Body, Course, Group, Place};

pub(super) const PROTOCOL: &str = "cosim.live.v1";

/// A browser.
#[derive(Default)]
pub(super) struct Page {
    columns: Vec<usize>,
    show: u32,
    width: usize,
}

impl Speaker for Page {
    fn greet(&mut self, about: &About) -> Vec<Message> {
        self.width = about.columns.len();
        let columns = about.columns.iter().map(
            |column| json!({ "name": column.name, "unit": column.unit().unwrap_or_default() }),
        );
        let hello = json!({
            "op": "hello",
            "name": about.name,
            "start": about.start.seconds(),
            "stop": about.stop.seconds(),
            "columns": columns.collect::<Vec<_>>(),
            "up": about.roles.axes == Axes::Enu,
            "bodies": about.roles.bodies.iter().map(body).collect::<Vec<_>>(),
            "courses": about.roles.courses.iter().map(course).collect::<Vec<_>>(),
            "kinds": KINDS.iter().map(kind).collect::<Vec<_>>(),
            "faults": about.faults,
        });
        vec![Message::text(hello.to_string())]
    }

    fn newest(&mut self, newest: &Newest, dropped: u64) -> Option<Message> {
        let state = json!({
            "op": "state",
            "time": newest.time.seconds(),
            "paused": newest.playing.paused,
            "speed": newest.playing.speed,
            "factor": newest.factor,
            "ended": newest.ended,
            "dropped": dropped,
        });
        Some(Message::text(state.to_string()))
    }

    fn event(&mut self, event: String) -> Option<Message> {
        Some(Message::text(event))
    }

    fn batch(&mut self, batch: &Batch) -> Vec<Message> {
        if self.show == 0 || batch.times.is_empty() {
            Vec::new()
        } else {
            vec![self.frame(batch, 0)]
        }
    }

    fn heard(&mut self, message: Message, hub: &Hub) -> Vec<Message> {
        let Message::Text(text) = message else { return Vec::new() };
        let Ok(Value::Object(said)) = serde_json::from_str::<Value>(&text) else {
            return Vec::new();
        };
        if said.get("op").and_then(Value::as_str) == Some("show") {
            return self.show(&said, hub).into_iter().collect();
        }
        if let Some(request) = request(said) {
            hub.request(request);
        }
        Vec::new()
    }
}

impl Page {
    fn show(&mut self, said: &Map<String, Value>, hub: &Hub) -> Option<Message> {
        let place = |value: &Value| usize::try_from(value.as_u64()?).ok();
        let columns = said.get("columns")?.as_array()?.iter().map(place);
        let columns = columns.collect::<Option<Vec<_>>>()?;
        if columns.iter().any(|column| *column >= self.width) {
            return None;
        }
        self.columns = columns;
        self.show = u32::try_from(said.get("number")?.as_u64()?).ok()?;
        let history = locked(&hub.history).all();
        Some(self.frame(&history, 1))
    }

    fn frame(&self, batch: &Batch, history: u32) -> Message {
        let head = [batch.times.len() as u32, self.show, history, self.columns.len() as u32];
        let mut frame = Vec::with_capacity(16 + 8 * batch.times.len() * (1 + self.columns.len()));
        frame.extend(head.iter().flat_map(|number| number.to_le_bytes()));
        let times = batch.times.iter().map(|time| *time as f64 / 1e9);
        frame.extend(times.flat_map(f64::to_le_bytes));
        for (_, row) in batch.rows() {
            frame.extend(self.columns.iter().flat_map(|column| row[*column].to_le_bytes()));
        }
        Message::binary(frame)
    }
}

fn request(mut said: Map<String, Value>) -> Option<Request> {
    let op = said.remove("op")?;
    Some(match op.as_str()? {
        "pause" => Request::Pause,
        "play" => Request::Play,
        "step" => Request::Step,
        "speed" => {
            let factor = said.get("factor").and_then(Value::as_f64);
            Request::Speed(factor.map(|factor| factor.clamp(SPEEDS.0, SPEEDS.1)))
        }
        "fault" => match said.remove("fault")? {
            Value::Object(fault) => Request::Inject(fault),
            _ => return None,
        },
        _ => return None,
    })
}

/// The columns of a group, each with its conversion to base units: a factor and an offset.
fn columns<const N: usize>(group: &Group<N>) -> Vec<Option<(usize, f64, f64)>> {
    group.places().iter().map(|place| place.map(Place::numbers)).collect()
}

fn course(course: &Course) -> Value {
    json!({ "name": course.name, "position": columns(&course.position) })
}

fn body(body: &Body) -> Value {
    let both = body.covariances.iter().find(|(one, other, _)| (*one, *other) == (0, 1));
    json!({
        "name": body.name,
        "truth": body.is_truth,
        "pose": columns(&body.pose),
        "sigma": columns(&body.sigma),
        "xy": both.map(|(_, _, place)| place.numbers()),
    })
}

fn kind(word: &cosim_core::scenario::Word) -> Value {
    let keys = word
        .keys
        .iter()
        .map(|meant| json!({ "key": meant.key, "meaning": meant.meaning, "words": meant.words }));
    json!({
        "name": word.name, "meaning": word.meaning, "example": word.example,
        "keys": keys.collect::<Vec<_>>(),
    })
}
