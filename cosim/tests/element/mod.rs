//! The C FMU beside this file, compiled by `cc`, and chains of it.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Compiles the library into a folder.
pub(crate) fn library(folder: &Path) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/element/element.c");
    let library = folder.join("element.so");
    let mut compiler = Command::new("cc");
    compiler.args(["-O2", "-shared", "-fPIC", "-w", "-o"]).arg(&library).arg(source);
    assert!(compiler.status().expect("a C compiler named cc").success());
    library
}

/// Packs the FMU into a folder.
pub(crate) fn fmu(folder: &Path) -> PathBuf {
    let library = std::fs::read(library(folder)).unwrap();
    let path = folder.join("element.fmu");
    let mut zip = ZipWriter::new(std::fs::File::create(&path).unwrap());
    let entries = [
        ("modelDescription.xml", &include_bytes!("element.xml")[..]),
        ("binaries/linux64/element.so", &library),
    ];
    for (name, bytes) in entries {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
    path
}

/// Writes the system in which `g1.u` is `g0.y` and so on, the first with a ramp.
pub(crate) fn chain(fmu: &Path, length: usize, step: f64, stop: f64) -> PathBuf {
    let mut components = String::new();
    let mut connections = String::new();
    for position in 0..length {
        let slope = f64::from(u8::from(position == 0));
        write!(
            components,
            "<ssd:Component name='g{position}' type='application/x-fmu-sharedlibrary' source='{}'>
<ssd:Connectors><ssd:Connector name='u' kind='input'><ssc:Real/></ssd:Connector>
<ssd:Connector name='y' kind='output'><ssc:Real/></ssd:Connector></ssd:Connectors>
<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version='1.0' name='p'>
<ssv:Parameters><ssv:Parameter name='b'><ssv:Real value='{slope}'/></ssv:Parameter></ssv:Parameters>
</ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Component stepSize='{step}'/></ssc:Annotation>
</ssd:Annotations></ssd:Component>\n",
            fmu.display()
        )
        .unwrap();
        if position > 0 {
            writeln!(
                connections,
                "<ssd:Connection startElement='g{}' startConnector='y' endElement='g{position}' \
                 endConnector='u'/>",
                position - 1
            )
            .unwrap();
        }
    }
    let file = fmu.with_file_name(format!("chain-{length}.ssd"));
    let text = format!(
        "<ssd:SystemStructureDescription version='1.0' name='chain'
 xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription'
 xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'
 xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues' xmlns:cosim='urn:cosim:1'>
<ssd:System name='chain'><ssd:Elements>\n{components}</ssd:Elements>
<ssd:Connections>\n{connections}</ssd:Connections></ssd:System>
<ssd:DefaultExperiment startTime='0' stopTime='{stop}'/></ssd:SystemStructureDescription>\n"
    );
    std::fs::write(&file, text).unwrap();
    file
}
