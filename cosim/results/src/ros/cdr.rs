//! Values in the encoding of ROS 2: CDR, little-endian, each aligned to its size.

use cosim_base::time::Time;

/// The start of a message: CDR, little-endian, no options.
pub(crate) const CDR_HEADER: [u8; 4] = [0, 1, 0, 0];

/// Appends values to a message.
pub(crate) struct Cdr<'a>(&'a mut Vec<u8>);

impl<'a> Cdr<'a> {
    /// Begins a message; `bytes` must be empty.
    pub(crate) fn new(bytes: &'a mut Vec<u8>) -> Self {
        bytes.extend(CDR_HEADER);
        Self(bytes)
    }

    fn align(&mut self, size: usize) {
        let place = (self.0.len() - CDR_HEADER.len()).next_multiple_of(size);
        self.0.resize(place + CDR_HEADER.len(), 0);
    }

    pub(crate) fn float64(&mut self, value: f64) {
        self.align(8);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn float64s(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.float64(*value));
    }

    pub(crate) fn int32(&mut self, value: i32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn uint32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn bool(&mut self, value: bool) {
        self.0.push(u8::from(value));
    }

    /// Its length includes a trailing zero.
    pub(crate) fn string(&mut self, text: &str) {
        self.uint32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// `std_msgs/Header`; a time after 2038 becomes the last second that ROS can represent.
    pub(crate) fn header(&mut self, stamp: Time, frame: &str) {
        const SECOND: i64 = 1_000_000_000;
        let nanoseconds = stamp.ns();
        self.int32(i32::try_from(nanoseconds / SECOND).unwrap_or(i32::MAX));
        self.uint32((nanoseconds % SECOND).unsigned_abs() as u32);
        self.string(frame);
    }
}
