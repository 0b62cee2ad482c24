//! Courses as text: lines `x,y[,radius]` in metres, an optional header, comments from `#` on.

use super::course::{Course, CourseError, Place, Waypoint};

/// The columns of a course, as the optional header names them.
const HEADER: [&str; 3] = ["x", "y", "radius"];

impl Course {
    /// The paper's first test course: a straight, a turn of fixed radius and a sharp turn.
    pub const BE1: &str = "x,y,radius\n0,0\n25,0,5\n25,20,0\n40,20\n";

    /// The second: a sinusoid of constant radius.
    pub const BE2: &str = "x,y,radius\n0,0\n10,0,5\n10,10,5\n20,10,5\n20,0,5\n30,0,5\n30,10,5\n\
                           40,10,5\n40,0,5\n50,0,5\n50,10,5\n60,10\n";

    /// The third: U shapes, clockwise and counter-clockwise.
    pub const BE3: &str = "x,y,radius\n0,0\n25,0,5\n25,20,5\n5,20,5\n5,40,5\n25,40\n";

    /// Reads a course from text.
    ///
    /// # Errors
    /// Names the line that cannot be read, or whose point cannot be part of a course.
    pub fn parse(text: &str) -> Result<Self, CourseError> {
        // Some editors put a byte order mark first.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut points = Vec::new();
        let mut lines = Vec::new();
        let mut first = true;
        for (i, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or_default().trim();
            if content.is_empty() {
                continue;
            }
            let header = first && is_header(content);
            first = false;
            if !header {
                points.push(waypoint(content, i + 1)?);
                lines.push(i + 1);
            }
        }
        Self::new(&points).map_err(|mut error| {
            if let Place::Point(index) = error.place {
                error.place = lines.get(index).map_or(Place::Course, |&line| Place::Line(line));
            }
            error
        })
    }
}

/// As much of a text as goes into a message, in printable characters.
fn excerpt(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    let more = if start.len() < text.len() { "…" } else { "" };
    format!("{}{more}", start.escape_debug())
}

fn is_header(line: &str) -> bool {
    let names = line.split(',').map(|name| name.trim().to_ascii_lowercase());
    names.zip(HEADER).all(|(name, expected)| name == expected)
}

fn waypoint(line: &str, number: usize) -> Result<Waypoint, CourseError> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    if !(2..=3).contains(&fields.len()) {
        let reason = format!("expected `x,y` or `x,y,radius`, found `{}`", excerpt(line));
        return Err(CourseError::new(Place::Line(number), reason));
    }
    let number_at = |i: usize| -> Result<f64, CourseError> {
        fields.get(i).map_or(Ok(0.0), |field| {
            field.parse().map_err(|_| {
                let reason = format!("{} = `{}` is not a number", HEADER[i], excerpt(field));
                CourseError::new(Place::Line(number), reason)
            })
        })
    };
    Ok(Waypoint { x: number_at(0)?, y: number_at(1)?, radius: number_at(2)? })
}
