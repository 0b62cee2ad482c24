//! Reads results and input signals: CSV with a header and the time in the first column.
//!
//! Our own files have quotes around every String and around nothing else. Other programs also quote
//! numbers, so the contents decide, too ([`forms`]).

use std::path::Path;

use super::Recording;
use super::csv::Form;
use cosim_base::error::{Code, Error, Result};
use cosim_base::texts;

/// Each column needs some memory, however short its name is.
const MAX_COLUMNS: usize = 2_000_000;

/// Reads `file`.
pub(super) fn read(file: &Path) -> Result<Recording> {
    let text = cosim_base::files::read_input_text(file)
        .map_err(|e| Error::new(Code::File, "the results cannot be read").at(file).why(e))?;
    parse(&text, file)
}

/// Reads a file whose writer may have been killed: an incomplete last record is ignored.
pub(super) fn read_unfinished(file: &Path) -> Result<Recording> {
    let bytes = cosim_base::files::read_input(file)
        .map_err(|e| Error::new(Code::File, "the results cannot be read").at(file).why(e))?;
    // An incomplete record may look like a shorter number.
    let (mut whole, mut quoted) = (0, false);
    for (place, byte) in bytes.iter().enumerate() {
        quoted ^= *byte == b'"';
        if *byte == b'\n' && !quoted {
            whole = place + 1;
        }
    }
    let text = std::str::from_utf8(&bytes[..whole])
        .map_err(|e| Error::new(Code::Results, "the results are not text").at(file).why(e))?;
    if whole == 0 && !bytes.is_empty() {
        return Err(Error::new(Code::Results, "the results end within their first line")
            .at(file)
            .why("the file may be truncated: the run was killed while writing")
            .help("run again"));
    }
    let read = parse(text, file)?;
    Ok(if whole == bytes.len() { read } else { read.unfinished("its last line has no end") })
}

fn parse(text: &str, file: &Path) -> Result<Recording> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = || records(text).filter(|(_, line)| !line.trim().is_empty());
    let wrong = |line: usize, what: String| Error::new(Code::Results, what).at_line(file, line + 1);
    let (_, header) = lines().next().ok_or_else(|| wrong(0, "the file is empty".to_owned()))?;
    if header.bytes().filter(|byte| *byte == b',').count() > MAX_COLUMNS {
        return Err(wrong(0, format!("more than {MAX_COLUMNS} columns are refused")));
    }
    let mut names = split(header);
    if names.first().is_none_or(|first| first != "time") {
        return Err(wrong(0, format!("the first column is '{}'", names.first().map_or("", |n| n)))
            .why("results begin with a header line whose first name is: time"));
    }
    names.remove(0);
    let mut time = Vec::new();
    let mut columns = vec![Vec::new(); names.len()];
    let forms = forms(lines().skip(1).map(|(_, line)| line), names.len());
    for (number, line) in lines().skip(1) {
        let mut fields = Fields(Some(line));
        let mut next = |name: &str| fields.next().ok_or_else(|| cut(wrong, number, name));
        let numbered = |field: &str, name: &str| {
            let text = inside(field).unwrap_or(field);
            number_of(text)
                .ok_or_else(|| wrong(number, format!("'{text}' in '{name}' is not a number")))
        };
        time.push(numbered(next("time")?, "time")?);
        for ((column, name), form) in columns.iter_mut().zip(&names).zip(&forms) {
            let field = next(name)?;
            column.push(match (form, inside(field)) {
                (Form::Text, Some(text)) => texts::number(&text.replace("\"\"", "\"")),
                (Form::Text, None) => {
                    return Err(wrong(number, format!("{field} in '{name}' is not in quotes")));
                }
                _ => numbered(field, name)?,
            });
        }
        if fields.next().is_some() {
            return Err(wrong(number, "the line has more fields than the header".to_owned()));
        }
    }
    Ok(Recording::from_columns(names, time, columns).with_forms(forms))
}

/// The types of the columns. A column whose first field is quoted holds Strings if a quoted field
/// of it is not a number, or if all of it is quoted in a file that does not quote the time: so our
/// own Strings stay Strings, and a program that quotes everything means nothing by it.
fn forms<'t>(lines: impl Iterator<Item = &'t str>, count: usize) -> Vec<Form> {
    let mut lines = lines.peekable();
    if !lines.peek().is_some_and(|first| first.contains('"')) {
        return vec![Form::Real; count];
    }
    let (mut first, mut words, mut plain) =
        (vec![false; count + 1], vec![false; count + 1], vec![false; count + 1]);
    for (row, line) in lines.enumerate() {
        for (place, field) in Fields(Some(line)).take(count + 1).enumerate() {
            match inside(field) {
                Some(text) => words[place] |= number_of(text).is_none(),
                None => plain[place] = true,
            }
            if row == 0 {
                first[place] = !plain[place];
            }
        }
    }
    let is_text = |place: usize| first[place] && (words[place] || !first[0] && !plain[place]);
    (1..=count).map(|place| if is_text(place) { Form::Text } else { Form::Real }).collect()
}

fn cut(wrong: impl Fn(usize, String) -> Error, line: usize, name: &str) -> Error {
    wrong(line, format!("the line ends before the column '{name}'"))
        .why("the file may be truncated: the run was killed while writing")
}

/// The records with the numbers of their lines, from 0; a quoted field may span several lines.
fn records(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let (mut rest, mut line) = (text, 0);
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let mut quoted = false;
        let end = rest.bytes().position(|byte| {
            quoted ^= byte == b'"';
            byte == b'\n' && !quoted
        });
        let (record, more) = end.map_or((rest, ""), |end| (&rest[..end], &rest[end + 1..]));
        let number = line;
        line += 1 + record.matches('\n').count();
        rest = more;
        Some((number, record.strip_suffix('\r').unwrap_or(record)))
    })
}

/// The fields of a record, with their quotes.
struct Fields<'t>(Option<&'t str>);

impl<'t> Iterator for Fields<'t> {
    type Item = &'t str;

    fn next(&mut self) -> Option<&'t str> {
        let rest = self.0?;
        let mut quoted = false;
        let end = match rest.trim_start().starts_with('"') {
            true => rest.bytes().position(|byte| {
                quoted ^= byte == b'"';
                byte == b',' && !quoted
            }),
            false => rest.find(','),
        };
        self.0 = end.map(|end| &rest[end + 1..]);
        Some(end.map_or(rest, |end| &rest[..end]))
    }
}

/// What is in the quotes of a field.
fn inside(field: &str) -> Option<&str> {
    field.trim().strip_prefix('"')?.strip_suffix('"')
}

/// A number or a Boolean as text.
pub(super) fn number_of(field: &str) -> Option<f64> {
    match field.trim() {
        "true" | "True" => Some(1.0),
        "false" | "False" => Some(0.0),
        field => field.parse().ok(),
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
        assert_eq!(read(file.path()).unwrap().missing(), None);
        let unfinished = read_unfinished(file.path()).unwrap();
        assert_eq!(unfinished.time(), [0.0]);
        assert!(unfinished.missing().unwrap().ends_with("there is nothing after t = 0 s"));
        std::fs::write(file.path(), "time,a\n0.0,1.5\n").unwrap();
        assert_eq!(read_unfinished(file.path()).unwrap().missing(), None);
        std::fs::write(file.path(), "time,a").unwrap();
        assert!(read_unfinished(file.path()).unwrap_err().to_string().contains("first line"));
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
    fn quotes_around_numbers_mean_nothing_where_everything_is_quoted() {
        let read = |text: &str| parse(text, Path::new("x.csv")).unwrap();
        let all = read("\"time\",\"u\",\"s\"\r\n\"0\",\"1.5\",\"1\"\r\n\"1\",\"-2\",\"x\"\r\n");
        assert_eq!(all.time(), [0.0, 1.0]);
        assert_eq!(all.column("u").unwrap(), [1.5, -2.0]);
        assert_eq!(&*all.text("s").unwrap()[0], "1");
        // Strings of our own that look like numbers.
        let own = read("time,s,x\n0,\"1\",1\n1,\"2\",2\n");
        assert_eq!(&*own.text("s").unwrap()[1], "2");
        assert!(own.column("s").unwrap_err().to_string().contains("'s' holds Strings"));
        assert_eq!(&*own.numbers(0).unwrap(), [1.0, 2.0]);
        // A column of numbers of which some are quoted.
        let some = read("time,u,v\n0,\"1\",2\n1,2,\"1\"\n");
        assert_eq!(some.column("u").unwrap(), [1.0, 2.0]);
        assert_eq!(some.column("v").unwrap(), [2.0, 1.0]);
    }

    #[test]
    fn line_breaks_in_strings_are_kept_and_do_not_end_a_record() {
        let (lines, one) = ("a\r\nb\n\"c\"", "1.5");
        let columns = vec![vec![texts::number(lines), texts::number(one)], vec![1.0, 2.0]];
        let names = ["s", "x"].map(str::to_owned).to_vec();
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns)
            .with_forms(vec![Form::Text, Form::Real]);
        let file = tempfile::NamedTempFile::new().unwrap();
        recording.write_csv(file.path()).unwrap();
        assert_eq!(super::read(file.path()).unwrap(), recording);
        // Wherever its writer is killed, the whole records can be read.
        let bytes = std::fs::read(file.path()).unwrap();
        let row = bytes.len() - "1.0,\"1.5\",2.0\n".len();
        let header = "time,s,x\n".len();
        for end in header..=bytes.len() {
            std::fs::write(file.path(), &bytes[..end]).unwrap();
            let samples = usize::from(end >= row) + usize::from(end == bytes.len());
            assert_eq!(read_unfinished(file.path()).unwrap().time().len(), samples, "{end}");
        }
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
            ("time,s,a\n0,\"x\ny\",1\n1,\"\",z", ":4"),
        ] {
            let error = parse(text, Path::new("x.csv")).err().map(|e| e.to_string());
            assert!(error.as_ref().is_some_and(|e| e.contains(place)), "{text}: {error:?}");
        }
    }
}
