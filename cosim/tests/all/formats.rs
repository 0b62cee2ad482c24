//! Texts of systems for tests of the formats, and FMUs with units.

use std::path::{Path, PathBuf};

use cosim::{Overrides, Recording, System};
use tempfile::TempDir;

use crate::models::{Model, compile, pack};
use crate::ssd::run;

/// An SSP description around the contents of its system.
pub(crate) fn ssd(inside: &str, after: &str) -> String {
    format!(
        "<?xml version='1.0' encoding='UTF-8'?>
<ssd:SystemStructureDescription version='1.0' name='test'
 xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription'
 xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'
 xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'
 xmlns:ssm='http://ssp-standard.org/SSP1/SystemStructureParameterMapping'>
<ssd:System name='test'>
{inside}
</ssd:System>
{after}
<ssd:DefaultExperiment startTime='0' stopTime='1'/>
</ssd:SystemStructureDescription>
"
    )
}

/// A component with its connectors `name:kind:Type` or `name:kind:Real:unit`.
pub(crate) fn component(name: &str, source: &Path, connectors: &str, extra: &str) -> String {
    format!(
        "<ssd:Component name='{name}' source='{}'><ssd:Connectors>\n{}</ssd:Connectors>{extra}\
         </ssd:Component>\n",
        source.display(),
        listed(connectors)
    )
}

pub(crate) fn listed(connectors: &str) -> String {
    let one = |text: &str| {
        let parts: Vec<&str> = text.split(':').collect();
        let unit = parts.get(3).map_or(String::new(), |unit| format!(" unit='{unit}'"));
        let (name, kind, value) = (parts[0], parts[1], parts[2]);
        format!("<ssd:Connector name='{name}' kind='{kind}'><ssc:{value}{unit}/></ssd:Connector>\n")
    };
    connectors.split_whitespace().map(one).collect()
}

/// `a.y b.u`; an end without a dot is a connector of the system itself.
pub(crate) fn connection(from: &str, to: &str, inside: &str) -> String {
    let end = |which: &str, text: &str| match text.rsplit_once('.') {
        Some((element, connector)) => {
            format!("{which}Element='{element}' {which}Connector='{connector}'")
        }
        None => format!("{which}Connector='{text}'"),
    };
    let (start, end) = (end("start", from), end("end", to));
    format!("<ssd:Connection {start} {end}>{inside}</ssd:Connection>\n")
}

/// Elements and connections of a system.
pub(crate) fn system(elements: &str, connections: &str) -> String {
    format!(
        "<ssd:Elements>{elements}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections>"
    )
}

/// Files of one test, in a folder that is removed with it.
pub(crate) struct Folder(pub TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }

    /// A model under another name, its description changed.
    pub(crate) fn fmu(&self, model: Model, name: &str, changes: &[(&str, &str)]) -> PathBuf {
        let mut description = model.description();
        for (from, to) in changes {
            assert!(description.contains(from), "{from}");
            description = description.replace(from, to);
        }
        let path = self.path(&format!("{name}.fmu"));
        let library = std::fs::read(compile(model)).unwrap();
        let binary = format!("binaries/linux64/{}.so", model.name());
        let entries =
            [("modelDescription.xml", description.into_bytes()), (binary.as_str(), library)];
        pack(&path, &entries);
        path
    }

    /// A model whose u and y are in that unit, defined by the attributes of its base.
    pub(crate) fn fmu_in(&self, model: Model, unit: &str, base: &str) -> PathBuf {
        let definition = format!(
            "<UnitDefinitions><Unit name=\"{unit}\"><BaseUnit {base}/></Unit></UnitDefinitions>\n  \
             <TypeDefinitions>"
        );
        let unit = format!("unit=\"{unit}\"");
        let name = format!("{}_{}", model.name(), unit.len() + base.len());
        self.fmu(model, &name, &[("unit=\"m\"", &unit), ("<TypeDefinitions>", &definition)])
    }

    pub(crate) fn load(&self, text: &str) -> Result<System, cosim::Error> {
        System::load(self.write("test.ssd", text), &Overrides::new())
    }

    pub(crate) fn run(&self, text: &str) -> Recording {
        run(&self.load(text).unwrap())
    }

    /// The error for a text.
    pub(crate) fn error(&self, text: &str) -> String {
        self.load(text).err().map_or("none".to_owned(), |e| e.to_string())
    }
}

#[track_caller]
pub(crate) fn assert_parts(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "'{part}' is not in:\n{text}");
    }
}

/// The last value of a column.
pub(crate) fn last(results: &Recording, column: &str) -> f64 {
    *results.column(column).unwrap().last().unwrap()
}
