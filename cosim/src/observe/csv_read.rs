//! Reads results and input signals: CSV with a header and the time in the first column. A column
//! whose first field is quoted holds Strings.

use std::borrow::Cow;
use std::path::Path;

use super::Recording;
use super::csv::Form;
use crate::error::{Code, Error, Result};
use crate::texts;

/// Each column needs some memory, however short its name is.
const MAX_COLUMNS: usize = 2_000_000;

/// Reads `file`.
pub(super) fn read(file: &Path) -> Result<Recording> {
    let text = crate::files::read_input_text(file)
        .map_err(|e| Error::new(Code::File, "the results cannot be read").at(file).why(e))?;
    parse(&text, file)
}

/// Reads a file whose writer may have been killed: an incomplete last line is ignored.
pub(super) fn read_unfinished(file: &Path) -> Result<Recording> {
    let bytes = std::fs::read(file)
        .map_err(|e| Error::new(Code::File, "the results cannot be read").at(file).why(e))?;
    // An incomplete line may look like a shorter number.
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let text = std::str::from_utf8(&bytes[..whole])
        .map_err(|e| Error::new(Code::Results, "the results are not text").at(file).why(e))?;
    parse(text, file)
}

fn parse(text: &str, file: &Path) -> Result<Recording> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = records(text).filter(|(_, line)| !line.trim().is_empty());
    let wrong = |line: usize, what: String| Error::new(Code::Results, what).at_line(file, line + 1);
    let (_, header) = lines.next().ok_or_else(|| wrong(0, "the file is empty".to_owned()))?;
    if header.bytes().filter(|byte| *byte == b',').count() > MAX_COLUMNS {
        return Err(wrong(0, format!("more than {MAX_COLUMNS} columns are refused")));
    }
    let mut names = split(&header);
    if names.first().is_none_or(|first| first != "time") {
        return Err(wrong(0, format!("the first column is '{}'", names.first().map_or("", |n| n)))
            .why("results begin with a header line whose first name is: time"));
    }
    names.remove(0);
    let mut time = Vec::new();
    let mut columns = vec![Vec::new(); names.len()];
    let mut forms = vec![Form::Real; names.len()];
    for (number, line) in lines {
        let first = time.is_empty();
        if line.contains('"') {
            let mut fields = pieces(&line).into_iter();
            let mut next = |name: &str| fields.next().ok_or_else(|| cut(wrong, number, name));
            let numbered = |field: &str, name: &str| {
                number_of(field.trim())
                    .ok_or_else(|| wrong(number, format!("'{field}' in '{name}' is not a number")))
            };
            time.push(numbered(&next("time")?, "time")?);
            for ((column, name), form) in columns.iter_mut().zip(&names).zip(&mut forms) {
                let field = next(name)?;
                let quoted = field.trim().strip_prefix('"').and_then(|f| f.strip_suffix('"'));
                if first && quoted.is_some() {
                    *form = Form::Text;
                }
                column.push(match (quoted, *form) {
                    (Some(text), Form::Text) => texts::number(&text.replace("\"\"", "\"")),
                    (Some(text), _) => numbered(text, name)?,
                    (None, _) => numbered(&field, name)?,
                });
            }
            if fields.next().is_some() {
                return Err(wrong(number, "the line has more fields than the header".to_owned()));
            }
            continue;
        }
        let mut fields = line.split(',');
        let mut next = |name: &str| {
            let field = fields.next().ok_or_else(|| cut(wrong, number, name))?;
            number_of(field.trim())
                .ok_or_else(|| wrong(number, format!("'{field}' in '{name}' is not a number")))
        };
        time.push(next("time")?);
        for ((column, name), form) in columns.iter_mut().zip(&names).zip(&forms) {
            let value = next(name)?;
            if *form == Form::Text {
                return Err(wrong(number, format!("{value} in '{name}' is not in quotes")));
            }
            column.push(value);
        }
        if fields.next().is_some() {
            return Err(wrong(number, "the line has more fields than the header".to_owned()));
        }
    }
    Ok(Recording::from_columns(names, time, columns).with_forms(forms))
}

fn cut(wrong: impl Fn(usize, String) -> Error, line: usize, name: &str) -> Error {
    wrong(line, format!("the line ends before the column '{name}'"))
        .why("the file may be truncated: the run was killed while writing")
}

/// The lines with their numbers from 0; a quoted field may span several lines.
fn records(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut record = Cow::from(line);
        while record.matches('"').count() % 2 == 1 {
            let Some((_, more)) = lines.next() else { break };
            record = Cow::from(format!("{record}\n{more}"));
        }
        Some((number, record))
    })
}

/// The fields of a line, with their quotes.
fn pieces(line: &str) -> Vec<String> {
    let mut quoted = false;
    let parts = line.split(|c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    });
    parts.map(str::to_owned).collect()
}

fn number_of(field: &str) -> Option<f64> {
    match field {
        "true" | "True" => Some(1.0),
        "false" | "False" => Some(0.0),
        _ => field.parse().ok(),
    }
}

/// The names of a header; quotes keep commas together, a doubled quote means one.
fn split(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                fields.last_mut().map(|f| f.push('"')).unwrap_or_default();
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => fields.last_mut().map(|f| f.push(c)).unwrap_or_default(),
        }
    }
    fields.iter().map(|f| f.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fmpy_and_people_write() {
        let file = Path::new("x.csv");
        let read = parse("time,\"a[1,2]\",b\r\n0.0,1,True\n1e-3, 2.5,0\n\n", file).unwrap();
        assert_eq!(read.time(), [0.0, 0.001]);
        assert_eq!(read.column("a[1,2]").unwrap(), [1.0, 2.5]);
        assert_eq!(read.column("b").unwrap(), [1.0, 0.0]);
    }

    #[test]
    fn a_line_without_its_end_was_not_written_to_its_end() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "time,a\n0.0,1.5\n0.1,1.2").unwrap();
        assert_eq!(read(file.path()).unwrap().time(), [0.0, 0.1]);
        assert_eq!(read_unfinished(file.path()).unwrap().time(), [0.0]);
    }

    #[test]
    fn strings_stand_in_quotes_and_may_hold_anything() {
        let text = "time,s,x\n0,\"a, \"\"b\"\"\nc\",1\n1,\"\",2\n";
        let read = parse(text, Path::new("x.csv")).unwrap();
        assert_eq!(
            read.text("s").unwrap().iter().map(|s| &**s).collect::<Vec<_>>(),
            ["a, \"b\"\nc", ""]
        );
        assert_eq!(read.column("x").unwrap(), [1.0, 2.0]);
        assert!(read.text("x").is_err());
        let file = tempfile::NamedTempFile::new().unwrap();
        read.write_csv(file.path()).unwrap();
        assert_eq!(super::read(file.path()).unwrap(), read);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, place) in [
            ("", ":1"),
            ("t,a\n", ":1"),
            ("time,a\n0,1\n0.1", ":3"),
            ("time,a\n0,x", ":2"),
            ("time,a\n0,1,2", ":2"),
            ("time,a\n0,\"x\"\n1,2", ":3"),
            ("time,a\n0,1\n1,\"x\"", ":3"),
        ] {
            let error = parse(text, Path::new("x.csv")).err().map(|e| e.to_string());
            assert!(error.as_ref().is_some_and(|e| e.contains(place)), "{text}: {error:?}");
        }
    }
}
