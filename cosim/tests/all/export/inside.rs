//! Exported systems as parts of systems, side by side, and the messages of their inner FMUs.

use std::path::Path;

use cosim::fmi::{Fmu, Instance, Logging, Mailbox};
use cosim::{Overrides, System};

use super::{assert_same, export, get, seconds, set, step, variable};
use crate::formats::{Folder, component, connection, ssd};
use crate::models::Model::{self, Clock, Failing, Gain, Integrator};
use crate::ssd::{Ssd, run, zoo};

/// The chain clock -> gain -> integrator with its middle exported as an FMU.
fn around(inner: &Path) -> String {
    let parts = [
        component("clock", &Clock.fmu(), "y:output:Real", ""),
        component("middle", inner, "g.u:input:Real h.y:output:Real", ""),
        component("i", &Integrator.fmu(), "u:input:Real y:output:Real", ""),
    ];
    let middle =
        |which: &str, name: &str| format!("{which}Element='middle' {which}Connector='{name}'");
    let connections = format!(
        "<ssd:Connection startElement='clock' startConnector='y' {}/>\
         <ssd:Connection {} endElement='i' endConnector='u'/>",
        middle("end", "g.u"),
        middle("start", "h.y")
    );
    ssd(
        &format!(
            "<ssd:Elements>{}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections>",
            parts.concat()
        ),
        "",
    )
}

#[test]
fn a_part_of_a_chain_exported_again_and_again_delays_nothing() {
    let whole = Ssd::new()
        .add("clock", Clock)
        .add_with("g", Gain, &[("k", 3.0)], None)
        .add_with("h", Gain, &[("k", 0.1)], None)
        .add("i", Integrator)
        .connect("clock.y", "g.u")
        .connect("g.y", "h.u")
        .connect("h.y", "i.u");
    let wanted = whole.run();
    let middle = Ssd::new()
        .add_with("g", Gain, &[("k", 3.0)], None)
        .add_with("h", Gain, &[("k", 0.1)], None)
        .connect("g.y", "h.u");
    let inner = export(&middle.write(), &[]);
    let folder = Folder::new();
    let file = folder.write("around.ssd", &around(&inner.fmu));
    let column =
        |recording: &cosim::Recording, name: &str| recording.column(name).unwrap().to_vec();
    let i = column(&wanted, "i.y");
    assert_eq!(column(&run(&System::load(&file, &Overrides::new()).unwrap()), "i.y"), i);
    let twice = export(&file, &[]);
    let twice = twice.run(0.1, Overrides::new());
    assert_eq!(column(&twice, "i.y"), i);
    assert_eq!(column(&twice, "middle.h.y"), column(&wanted, "h.y"));
}

#[test]
fn many_instances_on_many_threads_do_not_meet() {
    let exported = export(&zoo().write(), &[]);
    let wanted = exported.run(0.1, Overrides::new());
    let last = |name: &str| *wanted.column(name).unwrap().last().unwrap();
    let names = ["mass.y", "slow.y", "p.y", "swing.y", "ball.y"];
    let wanted = names.map(last);
    let work = || {
        let mut instance = exported.started();
        (0..15).for_each(|k| step(&mut instance, f64::from(k) / 10.0, f64::from(k + 1) / 10.0));
        names.map(|name| get(&mut instance, name))
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..20).map(|_| scope.spawn(work)).collect();
        threads.into_iter().for_each(|thread| assert_eq!(thread.join().unwrap(), wanted));
    });
}

/// Status and text of each message of the exported FMU.
fn failing(parameter: f64) -> (cosim::Error, Vec<(i32, String)>) {
    let system = Ssd::new().add("tank", Failing).add("clock", Clock).connect("clock.y", "tank.u");
    let exported = export(&system.write(), &[]);
    let mailbox = std::sync::Arc::new(Mailbox::default());
    let logging = Logging { mailbox: Some(mailbox.clone()), ..Logging::default() };
    let mut instance = Instance::new(Fmu::open(&exported.fmu).unwrap(), "x", &logging).unwrap();
    set(&mut instance, "tank.second", parameter);
    instance.enter_initialization(seconds(0.0), seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    step(&mut instance, 0.0, 0.3);
    let error = instance.do_step(seconds(0.3), seconds(0.3)).unwrap_err();
    let reported = mailbox.take().into_iter().map(|m| (m.status, m.text)).collect();
    (error, reported)
}

#[test]
fn a_failure_inside_is_reported_by_the_component_and_once_by_the_system() {
    let (error, reported) = failing(0.45);
    assert_eq!(error.status(), Some(3));
    let [(3, inner), (3, own)] = &reported[..] else { panic!("{reported:?}") };
    assert_eq!(inner, "tank (logStatusError): the tank is empty");
    assert!(own.starts_with("fmi2DoStep: fmi2DoStep of 'tank' failed at t = 0.4"), "{own}");
    assert!(own.contains("the FMU returned Error"), "{own}");
}

#[test]
fn debug_messages_come_when_they_are_asked_for() {
    let exported = export(&Ssd::new().add("a", Gain).add("b", Gain).write(), &[]);
    let texts = |debug: bool| {
        let mailbox = std::sync::Arc::new(Mailbox::default());
        let logging = Logging { debug, mailbox: Some(mailbox.clone()), ..Logging::default() };
        let fmu = Fmu::open(&exported.fmu).unwrap();
        let mut instance = Instance::new(fmu, "x", &logging).unwrap();
        instance.enter_initialization(seconds(0.0), seconds(1.0)).unwrap();
        instance.exit_initialization().unwrap();
        step(&mut instance, 0.0, 0.2);
        mailbox.take().into_iter().map(|message| message.text).collect::<Vec<_>>()
    };
    let reported = texts(true);
    for line in ["a (logAll): step to 0.1 s", "b (logAll): step to 0.2 s"] {
        assert!(reported.iter().any(|text| text.starts_with(line)), "{line} in {reported:?}");
    }
    assert_eq!(texts(false), Vec::<String>::new());
}

#[test]
fn debug_messages_can_be_asked_for_between_steps() {
    let exported = export(&Ssd::new().add("a", Gain).write(), &[]);
    let mailbox = std::sync::Arc::new(Mailbox::default());
    let logging = Logging { mailbox: Some(mailbox.clone()), ..Logging::default() };
    let mut instance = Instance::new(Fmu::open(&exported.fmu).unwrap(), "x", &logging).unwrap();
    instance.enter_initialization(seconds(0.0), seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    for (number, debug) in [false, true, false].into_iter().enumerate() {
        instance.debug(debug).unwrap();
        mailbox.take();
        let (begin, end) = (0.1 * number as f64, 0.1 * (number + 1) as f64);
        step(&mut instance, begin, end);
        let reported = mailbox.take();
        let inner = reported.iter().any(|message| message.text.starts_with("a (logAll): step to"));
        assert_eq!(inner, debug, "{reported:?}");
    }
}

#[test]
fn a_discarded_step_inside_is_a_discarded_step() {
    let system = Ssd::new().add_with("picky", Model::Picky, &[("second", 0.05)], None);
    let exported = export(&system.write(), &[]);
    let mut instance = exported.started();
    assert!(instance.try_step(seconds(0.0), seconds(0.1)).unwrap() < seconds(0.1));
    let tried = export(&system.write(), &["--retries", "5"]);
    let mut instance = tried.started();
    assert_eq!(instance.try_step(seconds(0.0), seconds(0.1)).unwrap(), seconds(0.1));
}

#[test]
fn a_component_that_ends_the_run_ends_it() {
    let ends = [("m", 2.0), ("second", 0.25)];
    let system = Ssd::new().add_with("picky", Model::Picky, &ends, None).stop(1.0);
    let exported = export(&system.write(), &[]);
    let mut instance = exported.started();
    step(&mut instance, 0.0, 0.2);
    let error = instance.do_step(seconds(0.2), seconds(0.1)).unwrap_err();
    assert_eq!(error.code(), cosim::Code::Ended, "{error}");
}

#[test]
fn connectors_of_the_system_are_its_variables() {
    let folder = Folder::new();
    let inside = component("g", &Gain.fmu(), "u:input:Real:m y:output:Real:m k:parameter:Real", "")
        + &component("h", &Gain.fmu(), "u:input:Real:m y:output:Real:m", "");
    let ports = crate::formats::listed(
        "demand:input:Real:cm gain:parameter:Real height:output:Real:cm loose:input:Real",
    );
    let factor = "<ssc:LinearTransformation factor='2'/>";
    let connections = [
        connection("demand", "g.u", ""),
        connection("demand", "h.u", factor),
        connection("gain", "g.k", ""),
        connection("g.y", "height", ""),
    ];
    let units = "<ssd:Units><ssc:Unit name='cm'><ssc:BaseUnit m='1' factor='0.01'/></ssc:Unit>\
                 <ssc:Unit name='m'><ssc:BaseUnit m='1'/></ssc:Unit></ssd:Units>";
    let text = ssd(
        &format!(
            "<ssd:Connectors>{ports}</ssd:Connectors><ssd:Elements>{inside}</ssd:Elements>\
             <ssd:Connections>{}</ssd:Connections>",
            connections.concat()
        ),
        units,
    );
    let exported = export(&folder.write("test.ssd", &text), &[]);
    let description = exported.description();
    assert!(!description.contains("name=\"g.u\"") && !description.contains("name=\"g.k\""));
    assert!(description.contains("<Real unit=\"cm\" start=\"0.0\"/>"), "{description}");
    let mut instance = exported.instance();
    set(&mut instance, "gain", 3.0);
    instance.enter_initialization(seconds(0.0), seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    set(&mut instance, "demand", 50.0);
    step(&mut instance, 0.0, 0.1);
    let found = ["height", "g.y", "h.y"].map(|name| get(&mut instance, name));
    assert_eq!(found, [150.0, 1.5, 1.0]);
    let run = exported.run(0.1, Overrides::new());
    assert_same(&run, &run);
}

#[test]
fn strings_between_inner_fmus_are_read_as_they_are() {
    let folder = Folder::new();
    let exported = export(&crate::texts::talk(&folder), &[]);
    let mut instance = exported.started();
    step(&mut instance, 0.0, 0.5);
    for name in ["a.said", "b.said"] {
        let reference = variable(&instance, name).value_reference;
        assert_eq!(instance.get_string(reference).unwrap(), "0.5 s, \"said\"", "{name}");
    }
}
