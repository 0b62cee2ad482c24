//! XML files as a small owned tree with line numbers.
//!
//! Both kinds of file read here (modelDescription.xml, SSP) are small enough for a tree, and a tree
//! allows the readers to be plain functions. Files are untrusted, so a DTD, entities other than the
//! five predefined ones, deep nesting and large numbers of elements are refused, and a tree takes
//! no more memory than `MAX_TREE` or 128 times its text: names and namespaces are stored once,
//! however often they occur.

use std::borrow::Cow;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use quick_xml::NsReader;
use quick_xml::XmlVersion;
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::name::ResolveResult;

use crate::error::{Code, Error, Result};

mod element;
pub use element::{Attribute, Element, Name};

const MAX_BYTES: u64 = 256 << 20;
const MAX_DEPTH: usize = 64;
const MAX_ELEMENTS: usize = 2_000_000;
const MAX_ATTRIBUTES: usize = 256;
/// Maximum length of the name of an element or attribute, in bytes.
const MAX_NAME: usize = 1024;
/// Memory for the tree of one file in bytes; if the process may have little, a quarter of that.
const MAX_TREE: u64 = 768 << 20;
/// Maximum memory of an element: the list that contains it doubles when it grows, and is copied.
const PER_ELEMENT: usize = 3 * size_of::<Element>();
/// Overhead of a text on the heap.
const PER_TEXT: usize = 32;
const LATIN_1: &str = "ISO-8859-1";

/// Reads and parses `file`; `shown` is its name in messages (a file in an archive is unpacked to a
/// location that the user has never seen).
pub fn read(file: &Path, shown: &Path) -> Result<Element> {
    let unreadable =
        |e: std::io::Error| Error::new(Code::File, "the file cannot be read").at(shown).why(e);
    let size = std::fs::metadata(file).map_err(unreadable)?.len();
    if size > MAX_BYTES {
        return Err(Error::new(Code::Xml, format!("the file has {size} bytes"))
            .at(shown)
            .why(format!("more than {MAX_BYTES} are refused")));
    }
    decode(&crate::files::read_input(file).map_err(unreadable)?, shown)
}

/// Parses the bytes of a file: UTF-8, or ISO-8859-1 if declared, as in files of 20-sim and Modelon.
/// `file` is its name in messages.
pub fn decode(bytes: &[u8], file: &Path) -> Result<Element> {
    if declares_latin_1(bytes) {
        let text: String = bytes.iter().copied().map(char::from).collect();
        return parse(&text, file);
    }
    let wrong = |line| Error::new(Code::Xml, "the file is not UTF-8").at_line(file, line);
    let help = "save it as UTF-8 with encoding=\"UTF-8\" in its first line";
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(wrong(1).why("it begins with the byte order mark of UTF-16").help(help));
    }
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let before = &bytes[..e.valid_up_to()];
        wrong(1 + before.iter().filter(|&&b| b == b'\n').count()).why(e).help(help)
    })?;
    parse(text, file)
}

fn declares_latin_1(bytes: &[u8]) -> bool {
    let end = bytes.iter().position(|byte| *byte == b'>').unwrap_or(0);
    let declaration = String::from_utf8_lossy(&bytes[..end]).to_ascii_uppercase();
    declaration.starts_with("<?XML") && declaration.contains(LATIN_1)
}

/// Parses `text`; `file` is its name in messages.
pub fn parse(text: &str, file: &Path) -> Result<Element> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    Parser {
        file,
        text,
        counted_to: 0,
        line: 1,
        open: Vec::new(),
        elements: 0,
        names: HashSet::new(),
        left: budget(),
    }
    .document()
}

/// The memory for a tree.
fn budget() -> u64 {
    let limit = rustix::process::getrlimit(rustix::process::Resource::As).current;
    limit.map_or(MAX_TREE, |limit| MAX_TREE.min(limit / 4))
}

struct Parser<'a> {
    file: &'a Path,
    text: &'a str,
    /// Newlines before this byte are in `line`.
    counted_to: usize,
    line: usize,
    /// The elements not yet closed, outermost first.
    open: Vec<Element>,
    elements: usize,
    /// Names and namespaces found so far.
    names: HashSet<Arc<str>>,
    /// Bytes of memory that the tree may still take.
    left: u64,
}

impl Parser<'_> {
    fn document(mut self) -> Result<Element> {
        let mut reader = NsReader::from_str(self.text);
        let mut root = None;
        loop {
            // An event starts where the last one ended; text before a tag is a separate event.
            self.count_lines(reader.buffer_position() as usize);
            let (namespace, event) = match reader.read_resolved_event() {
                Ok(read) => read,
                Err(e) => {
                    let at = reader.error_position() as usize;
                    self.count_lines(at);
                    return Err(self.wrong("the XML is not well-formed").why(e));
                }
            };
            let closed = match event {
                Event::Start(tag) => {
                    self.start(&namespace, &tag)?;
                    None
                }
                Event::Empty(tag) => {
                    self.start(&namespace, &tag)?;
                    self.open.pop()
                }
                Event::End(_) => self.open.pop(),
                Event::Text(text) => {
                    self.text(&text.xml10_content())?;
                    None
                }
                Event::CData(text) => {
                    self.text(&text.xml10_content())?;
                    None
                }
                Event::GeneralRef(reference) => {
                    self.reference(&reference)?;
                    None
                }
                Event::DocType(_) => {
                    return Err(self
                        .wrong("the file has a document type declaration (DTD)")
                        .help("remove the <!DOCTYPE ...>: FMI and SSP files have none"));
                }
                Event::Decl(declaration) => {
                    self.encoding(declaration.encoding())?;
                    None
                }
                Event::Comment(_) | Event::PI(_) => None,
                Event::Eof => break,
            };
            if let Some(mut element) = closed {
                element.children.shrink_to_fit();
                match self.open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None if root.is_none() => root = Some(element),
                    None => return Err(self.wrong("a second root element")),
                }
            }
        }
        if let Some(open) = self.open.pop() {
            return Err(self.wrong(format!("<{}> of line {} is not closed", open.name, open.line)));
        }
        root.ok_or_else(|| self.wrong("the file has no element"))
    }

    /// The text has already been decoded. A file that declares something else but contains only
    /// ASCII means the same; other characters would be misread.
    fn encoding(&self, declared: Option<Result<Cow<'_, str>, AttrError>>) -> Result<()> {
        let name = declared
            .transpose()
            .map_err(|e| self.wrong("the XML declaration is wrong").why(e))?
            .unwrap_or("UTF-8".into());
        let same = ["UTF-8", "UTF8", LATIN_1].iter().any(|known| name.eq_ignore_ascii_case(known));
        if same || (self.text.is_ascii() && !name.to_ascii_uppercase().starts_with("UTF-")) {
            return Ok(());
        }
        Err(self
            .wrong(format!("the file declares the encoding {name}"))
            .why("FMI and SSP files are UTF-8; ISO-8859-1 is also read")
            .help("save it as UTF-8 with encoding=\"UTF-8\" in its first line"))
    }

    fn start(&mut self, namespace: &ResolveResult<'_>, tag: &BytesStart<'_>) -> Result<()> {
        self.elements += 1;
        if self.open.len() >= MAX_DEPTH || self.elements > MAX_ELEMENTS {
            return Err(self
                .wrong("the XML is nested too deeply or has too many elements")
                .why(format!("the limits are {MAX_DEPTH} levels and {MAX_ELEMENTS} elements")));
        }
        let namespace = match namespace {
            ResolveResult::Bound(bound) => bound.into_inner(),
            ResolveResult::Unbound => "",
            ResolveResult::Unknown(prefix) => match customary(prefix) {
                Some(namespace) => namespace,
                // What other tools have to say does not concern this one.
                None if self.open.iter().any(|e| ANNOTATIONS.contains(&e.name.as_str())) => "",
                None => {
                    return Err(self
                        .wrong(format!("the prefix '{prefix}:' is not declared"))
                        .help(format!("declare it with xmlns:{prefix}=\"...\"")));
                }
            },
        };
        self.check_name(tag.name().into_inner())?;
        self.spend(PER_ELEMENT)?;
        let attributes = self.attributes(tag)?;
        let (namespace, name) = (self.name(namespace)?, self.name(tag.local_name().into_inner())?);
        let (line, children, text) = (self.line, Vec::new(), String::new());
        self.open.push(Element { namespace, name, line, attributes, children, text });
        Ok(())
    }

    fn attributes(&mut self, tag: &BytesStart<'_>) -> Result<Vec<Attribute>> {
        let mut attributes = Vec::new();
        // Names are compared below: the check in the reader is quadratic.
        for attribute in tag.attributes().with_checks(false) {
            let attribute = attribute.map_err(|e| self.wrong("an attribute is wrong").why(e))?;
            if attributes.len() == MAX_ATTRIBUTES {
                return Err(self.wrong(format!("more than {MAX_ATTRIBUTES} attributes")));
            }
            let value = attribute
                .normalized_value(XmlVersion::Explicit1_0)
                .map_err(|e| self.wrong("an attribute's value is wrong").why(e))?;
            let name = attribute.key.into_inner();
            self.check_name(name)?;
            self.spend(size_of::<Attribute>() + PER_TEXT + value.len())?;
            let name = self.name(name)?;
            attributes.push(Attribute { name, value: value.into_owned() });
        }
        let mut names: Vec<&str> = attributes.iter().map(|a| a.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(self.wrong(format!("the attribute '{}' occurs twice", pair[0])));
        }
        attributes.retain(|a| a.name != "xmlns" && !a.name.starts_with("xmlns:"));
        attributes.shrink_to_fit();
        Ok(attributes)
    }

    /// A name of this document, stored once.
    fn name(&mut self, text: &str) -> Result<Name> {
        if let Some(known) = self.names.get(text) {
            return Ok(Name::from(known.clone()));
        }
        self.spend(2 * PER_TEXT + 4 * size_of::<Arc<str>>() + text.len())?;
        let name: Arc<str> = text.into();
        self.names.insert(name.clone());
        Ok(Name::from(name))
    }

    /// Refuses content that would take more memory than the tree may have.
    fn spend(&mut self, bytes: usize) -> Result<()> {
        match self.left.checked_sub(bytes as u64) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(self
                .wrong("the file is refused: its content takes too much memory")
                .why(format!("more than {} MiB up to this line", budget() >> 20))),
        }
    }

    fn check_name(&self, name: &str) -> Result<()> {
        if name.len() <= MAX_NAME {
            return Ok(());
        }
        Err(self.wrong(format!("a name of {} bytes", name.len())))
    }

    fn text(&mut self, text: &str) -> Result<()> {
        // Texts grow by doubling.
        self.spend(3 * text.len())?;
        match self.open.last_mut() {
            Some(element) => element.text.push_str(text),
            None if text.trim().is_empty() => (),
            None => return Err(self.wrong("text outside the root element")),
        }
        Ok(())
    }

    fn reference(&mut self, reference: &BytesRef<'_>) -> Result<()> {
        let character = reference
            .resolve_char_ref()
            .map_err(|e| self.wrong("a character reference is wrong").why(e))?;
        if let Some(character) = character {
            return self.text(character.encode_utf8(&mut [0; 4]));
        }
        match quick_xml::escape::resolve_predefined_entity(reference) {
            Some(text) => self.text(text),
            None => Err(self
                .wrong(format!("the entity '&{};' is not expanded", &**reference))
                .why("only &lt; &gt; &amp; &apos; &quot; and character references are")),
        }
    }

    fn count_lines(&mut self, to: usize) {
        let bytes = self.text.as_bytes();
        let to = to.min(bytes.len());
        if to > self.counted_to {
            self.line += bytes[self.counted_to..to].iter().filter(|&&b| b == b'\n').count();
            self.counted_to = to;
        }
    }

    fn wrong(&self, what: impl Into<String>) -> Error {
        Error::new(Code::Xml, what).at_line(self.file, self.line)
    }
}

/// Elements with contents of any tool, in SSP and in FMI.
const ANNOTATIONS: [&str; 2] = ["Annotation", "VendorAnnotations"];

/// The namespace of a prefix that files in the field use without declaring it.
fn customary(prefix: &str) -> Option<&'static str> {
    Some(match prefix {
        "ssd" => "http://ssp-standard.org/SSP1/SystemStructureDescription",
        "ssc" => "http://ssp-standard.org/SSP1/SystemStructureCommon",
        "ssv" => "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
        "ssm" => "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
        "ssb" => "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary",
        "osp" => "http://opensimulationplatform.com/SSP/OSPAnnotations",
        "oms" => "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
        "cosim" => "urn:cosim:1",
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
