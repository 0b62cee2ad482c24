//! Courses as text: lines `x,y[,radius[,z]]` in metres, an optional header, comments from `#` on.

use super::course::Course;
use super::waypoint::{CourseError, Place, Waypoint};

/// The columns of a course, as the optional header names them.
const HEADER: [&str; 4] = ["x", "y", "radius", "z"];

impl Course {
    /// The paper's first test course: a straight, a turn of fixed radius and a sharp turn.
    pub const BE1: &str = "x,y,radius\n0,0\n25,0,5\n25,20,0\n40,20\n";

    /// The second: a sinusoid of constant radius.
    pub const BE2: &str = "x,y,radius\n0,0\n10,0,5\n10,10,5\n20,10,5\n20,0,5\n30,0,5\n30,10,5\n\
                           40,10,5\n40,0,5\n50,0,5\n50,10,5\n60,10\n";

    /// The third: U shapes, clockwise and counter-clockwise.
    pub const BE3: &str = "x,y,radius\n0,0\n25,0,5\n25,20,5\n5,20,5\n5,40,5\n25,40\n";

    /// A zigzag between 20 and 32 m of depth, slope 0.1 to 0.12, with turns both ways.
    pub const DIVE: &str = "x,y,radius,z\n0,0,0,20\n40,0,5,24\n40,20,5,22\n0,20,5,26\n\
                            0,40,5,28\n40,40,5,32\n40,60,0,30\n";

    /// A helix of radius 6 m and slope 0.35, clockwise: two turns down to 44.7 m and one up. The
    /// rounded corners of the square around it leave no straights.
    pub const HELIX: &str = "x,y,radius,z\n0,0,0,20\n\
                             6,0,6,21.6493\n6,12,6,24.9480\n-6,12,6,28.2467\n-6,0,6,31.5454\n\
                             6,0,6,34.8440\n6,12,6,38.1427\n-6,12,6,41.4414\n-6,0,6,44.7400\n\
                             6,0,6,41.4414\n6,12,6,38.1427\n-6,12,6,34.8440\n-6,0,6,31.5454\n\
                             0,0,0,29.8960\n";

    /// All of them, by name.
    pub const BUILT_IN: [(&str, &str); 5] = [
        ("BE1", Self::BE1),
        ("BE2", Self::BE2),
        ("BE3", Self::BE3),
        ("DIVE", Self::DIVE),
        ("HELIX", Self::HELIX),
    ];

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

/// As much of a text as fits into a message, in printable characters.
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
    if !(2..=HEADER.len()).contains(&fields.len()) {
        let found = excerpt(line);
        let reason = format!("expected `x,y`, `x,y,radius` or `x,y,radius,z`, found `{found}`");
        return Err(CourseError::new(Place::Line(number), reason));
    }
    let number_at = |i: usize| -> Result<Option<f64>, CourseError> {
        let Some(field) = fields.get(i) else { return Ok(None) };
        field.parse().map(Some).map_err(|_| {
            let reason = format!("{} = `{}` is not a number", HEADER[i], excerpt(field));
            CourseError::new(Place::Line(number), reason)
        })
    };
    let or_zero = |i| number_at(i).map(Option::unwrap_or_default);
    Ok(Waypoint { x: or_zero(0)?, y: or_zero(1)?, radius: or_zero(2)?, z: number_at(3)? })
}
