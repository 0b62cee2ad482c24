//! The Foxglove WebSocket protocol, as far as needed by a server of data with time and playback
//! control. Foxglove calls it `foxglove.sdk.v1`; Lichtblick and older programs use
//! `foxglove.websocket.v1`, which has no playback control.

use std::collections::HashMap;

use serde_json::{Value, json};
use tungstenite::Message;

use super::batch::Batch;
use super::client::Speaker;
use super::hub::{About, Hub, Newest, Playing, Request, SPEEDS};
use cosim_base::time::Time;
use cosim_results::ros::Channels;

const WITH_CONTROL: &str = "foxglove.sdk.v1";
pub(super) const PROTOCOLS: [&str; 2] = [WITH_CONTROL, "foxglove.websocket.v1"];

/// Binary message types of a server.
const DATA: u8 = 1;
const TIME: u8 = 2;
const STATE: u8 = 5;
/// A binary message type of a client.
const CONTROL: u8 = 3;

/// Foxglove or Lichtblick.
pub(super) struct Foxglove {
    controls: bool,
    /// The status that was sent last.
    sent: Option<(Playing, bool)>,
    channels: Option<Channels>,
    /// For each channel: the ids of the subscriptions.
    subscribed: HashMap<usize, Vec<u32>>,
}

impl Foxglove {
    pub(super) fn new(protocol: &str) -> Self {
        let controls = protocol == WITH_CONTROL;
        Self { controls, sent: None, channels: None, subscribed: HashMap::new() }
    }
}

impl Speaker for Foxglove {
    fn greet(&mut self, about: &About) -> Vec<Message> {
        let stamp = |time: Time| {
            let nanoseconds = time.ns().max(0);
            json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 })
        };
        let all = ["time", "playbackControl"];
        let capabilities = if self.controls { &all[..] } else { &all[..1] };
        let info = json!({
            "op": "serverInfo",
            "name": format!("cosim: {}", about.name),
            "capabilities": capabilities,
            "supportedEncodings": ["cdr"],
            "metadata": {},
            "dataStartTime": stamp(about.start),
            "dataEndTime": stamp(about.stop),
        });
        // The run itself has found the same roles.
        let Ok(channels) = Channels::new(&about.name, &about.columns, about.declared.as_ref())
        else {
            return vec![Message::text(info.to_string())];
        };
        let listed = channels.all.iter().enumerate().map(|(id, channel)| {
            json!({
                "id": id,
                "topic": format!("/{}", channel.topic),
                "encoding": "cdr",
                "schemaName": channel.schema_name,
                "schema": channel.schema,
                "schemaEncoding": "ros2msg",
            })
        });
        let advertised = json!({ "op": "advertise", "channels": listed.collect::<Vec<_>>() });
        self.channels = Some(channels);
        vec![Message::text(info.to_string()), Message::text(advertised.to_string())]
    }

    fn newest(&mut self, newest: &Newest, _: u64) -> Option<Message> {
        let going = (newest.playing.clone(), newest.ended);
        if !self.controls || self.sent.as_ref() == Some(&going) {
            return None;
        }
        self.sent = Some(going);
        Some(state(newest, ""))
    }

    fn event(&mut self, event: String) -> Option<Message> {
        let event: Value = serde_json::from_str(&event).ok()?;
        let level = if event["kind"] == "error" { 2 } else { 0 };
        let text = format!("t = {} s: {}", event["time"], event["text"].as_str()?);
        Some(Message::text(json!({ "op": "status", "level": level, "message": text }).to_string()))
    }

    fn batch(&mut self, batch: &Batch) -> Vec<Message> {
        let mut messages = Vec::new();
        let Some(channels) = self.channels.as_mut().filter(|_| !self.subscribed.is_empty()) else {
            return messages;
        };
        for (time, row) in batch.rows() {
            // The protocol has no times before zero.
            let Ok(stamp) = u64::try_from(time) else { continue };
            let subscribed = &self.subscribed;
            let Ok(()) = channels.each(Time::from_ns(time), row, |channel, data| {
                for number in subscribed.get(&channel).into_iter().flatten() {
                    let mut message = vec![DATA];
                    message.extend(number.to_le_bytes());
                    message.extend(stamp.to_le_bytes());
                    message.extend_from_slice(data);
                    messages.push(Message::binary(message));
                }
                Ok::<(), std::convert::Infallible>(())
            });
        }
        if let Some(newest) = batch.times.last().and_then(|time| u64::try_from(*time).ok()) {
            let mut message = vec![TIME];
            message.extend(newest.to_le_bytes());
            messages.push(Message::binary(message));
        }
        messages
    }

    fn heard(&mut self, message: Message, hub: &Hub) -> Vec<Message> {
        match message {
            Message::Text(text) => {
                if let Ok(said) = serde_json::from_str::<Value>(&text) {
                    self.subscription(&said);
                }
                Vec::new()
            }
            Message::Binary(bytes) if self.controls => control(&bytes, hub).into_iter().collect(),
            _ => Vec::new(),
        }
    }
}

impl Foxglove {
    /// Subscribes or unsubscribes; anything else is ignored.
    fn subscription(&mut self, said: &Value) -> Option<()> {
        let number = |value: &Value| u32::try_from(value.as_u64()?).ok();
        match said["op"].as_str()? {
            "subscribe" => {
                let count = self.channels.as_ref()?.all.len();
                for wanted in said["subscriptions"].as_array()? {
                    let channel = number(&wanted["channelId"])? as usize;
                    if channel < count {
                        let own = self.subscribed.entry(channel).or_default();
                        own.push(number(&wanted["id"])?);
                    }
                }
            }
            "unsubscribe" => {
                for ended in said["subscriptionIds"].as_array()?.iter().filter_map(number) {
                    self.subscribed.values_mut().for_each(|own| own.retain(|id| *id != ended));
                    self.subscribed.retain(|_, own| !own.is_empty());
                }
            }
            _ => (),
        }
        Some(())
    }
}

/// Plays or pauses at a speed; a run cannot go back, so seek requests are ignored.
fn control(bytes: &[u8], hub: &Hub) -> Option<Message> {
    let (&[kind, command], rest) = bytes.split_first_chunk::<2>()?;
    let (speed, rest) = rest.split_first_chunk::<4>()?;
    let (_, rest) = rest.split_first_chunk::<9>()?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let request = rest.get(..u32::from_le_bytes(*length) as usize)?;
    let speed = f64::from(f32::from_le_bytes(*speed)).clamp(SPEEDS.0, SPEEDS.1);
    if kind != CONTROL {
        return None;
    }
    let mut newest = hub.newest();
    if !speed.is_nan() && newest.playing.speed != Some(speed) {
        hub.request(Request::Speed(Some(speed)));
        newest.playing.speed = Some(speed);
    }
    newest.playing.paused = command == 1;
    hub.request(if newest.playing.paused { Request::Pause } else { Request::Play });
    Some(state(&newest, std::str::from_utf8(request).ok()?))
}

fn state(newest: &Newest, request: &str) -> Message {
    let status = match newest {
        Newest { ended: true, .. } => 3,
        _ => u8::from(newest.playing.paused),
    };
    let time = u64::try_from(newest.time.ns()).unwrap_or(0);
    let speed = newest.playing.speed.unwrap_or(newest.factor) as f32;
    let mut message = vec![STATE, status];
    message.extend(time.to_le_bytes());
    message.extend(speed.to_le_bytes());
    message.push(0);
    message.extend((request.len() as u32).to_le_bytes());
    message.extend(request.as_bytes());
    Message::binary(message)
}
