//! Exploration.
#[path = "mission/mod.rs"]
mod mission;
#[path = "scoring/mod.rs"]
mod scoring;
use mission::*;
use rexrov::guidance::Course;
use scoring::*;

const ALL: [Which; 4] = [Which::ConstantAcceleration, Which::Dynamic, Which::Inertial, Which::ModelAided];

fn seeds() -> u64 { std::env::var("SEEDS").ok().map_or(8, |s| s.parse().unwrap()) }

#[test]
fn nominal() {
    for which in ALL {
        let t = std::time::Instant::now();
        let runs = parallel(1..=seeds(), |seed| {
            let o = Options::nominal(Course::BE3, seed);
            run(which, &o, &fly(&o), |_| {})
        });
        let whole: Vec<f64> = runs.iter().map(|r| r.rmse(0.0, 1e9)).collect();
        let late: Vec<f64> = runs.iter().map(|r| r.rmse(30.0, 1e9)).collect();
        let z: Vec<f64> = runs.iter().map(|r| r.rms(30.0, |s| s.error[2])).collect();
        let h: Vec<f64> = runs.iter().map(|r| r.rms(30.0, |s| s.heading.to_degrees())).collect();
        let m = |f: fn(&Sample) -> f64| runs.iter().map(|r| r.mean(30.0, 1e9, f)).sum::<f64>() / runs.len() as f64;
        let nis: Vec<String> = (0..5).map(|c| format!("{:.2}", runs.iter().map(|r| r.nis[c].0).sum::<f64>() / runs.iter().map(|r| r.nis[c].1).sum::<u32>() as f64)).collect();
        println!("{which:?}: rmse {:.3}/{:.3} after30 {:.3}/{:.3} z {:.3} head {:.3} nees2 {:.2} nees4 {:.2} sig {:.3} nis {nis:?} rej {:?} {:?}",
            quantile(&whole, 0.5), quantile(&whole, 0.95), quantile(&late, 0.5), quantile(&late, 0.95), quantile(&z, 0.5), quantile(&h, 0.5),
            m(|s| s.nees2), m(|s| s.nees4), m(|s| s.sigma2).sqrt(), runs[0].last.channels.map(|c| c.rejected), t.elapsed());
    }
}

#[test]
fn outage() {
    for grade in [Grade::Adis, Grade::Industrial, Grade::Tactical] {
        for which in ALL {
            let runs = parallel(1..=seeds(), |seed| {
                let o = Options { duration_s: 262.0, ..Options::nominal(Course::BE3, seed) }.with_imu(grade);
                let mut m = fly(&o);
                drop(&mut m.events, Kind::Fix, 200.0, 260.0);
                drop(&mut m.events, Kind::Dvl, 200.0, 260.0);
                run(which, &o, &m, |_| {})
            });
            let e: Vec<f64> = runs.iter().map(|r| r.final_error(259.9)).collect();
            let n = runs.iter().map(|r| r.at(259.9).nees2).sum::<f64>() / runs.len() as f64;
            println!("{grade:?} {which:?}: {:.2}/{:.2} nees2 {n:.2}", quantile(&e, 0.5), quantile(&e, 0.95));
        }
    }
}

#[test]
fn variants() {
    let n = seeds();
    let show = |name: &str, which: Which, change: &(dyn Fn(&mut Options) + Sync), tune: &(dyn Fn(&mut rexrov::estimation::NavigationParameters) + Sync)| {
        let runs = parallel(1..=n, |seed| {
            let mut o = Options::nominal(Course::BE3, seed);
            change(&mut o);
            run(which, &o, &fly(&o), tune)
        });
        let late: Vec<f64> = runs.iter().map(|r| r.rmse(30.0, 1e9)).collect();
        let m = |f: fn(&Sample) -> f64| runs.iter().map(|r| r.mean(30.0, 1e9, f)).sum::<f64>() / runs.len() as f64;
        println!("{name} {which:?}: after30 {:.3}/{:.3} nees2 {:.2} nees4 {:.2} sig {:.3}", quantile(&late, 0.5), quantile(&late, 0.95), m(|s| s.nees2), m(|s| s.nees4), m(|s| s.sigma2).sqrt());
    };
    for w in [Which::Dynamic, Which::Inertial] {
        show("base", w, &|_| {}, &|_| {});
        show("no heading bias", w, &|_| {}, &|p| p.sensors.heading_bias_sigma = 0.0);
        show("heading bias .5 deg", w, &|_| {}, &|p| p.sensors.heading_bias_sigma = 0.0087);
        show("ahrs 50", w, &|o| { o.ahrs_hz = 50.0; o.heading_sigma = 0.0224 }, &|_| {});
    }
}

#[test]
fn losses() {
    for (i, fraction) in [(4usize, 1.0), (6, 1.0), (0, 1.0), (4, 0.5)] {
        for w in [Which::Dynamic, Which::ModelAided] {
            let runs = parallel(1..=seeds(), |seed| {
                let o = Options { duration_s: 262.0, lost_thruster: Some((i, 100.0)), lost_fraction: fraction, ..Options::nominal(Course::BE3, seed) };
                let mut m = fly(&o);
                drop(&mut m.events, Kind::Fix, 200.0, 260.0);
                drop(&mut m.events, Kind::Dvl, 200.0, 260.0);
                run(w, &o, &m, |p| p.sensors.heading_bias_sigma = 0.0)
            });
            let e: Vec<f64> = runs.iter().map(|r| r.final_error(259.9)).collect();
            let first = |r: &Run| r.path.iter().zip(&r.samples).find(|(p, _)| p.loss.iter().any(|l| *l > 0.0)).map(|(p, s)| (s.time - 100.0, p.loss.iter().position(|l| *l > 0.0).unwrap()));
            let firsts: Vec<_> = runs.iter().map(first).collect();
            let right = firsts.iter().filter(|f| f.is_some_and(|f| f.1 == i && f.0 > 0.0)).count();
            let t: Vec<f64> = firsts.iter().map(|f| f.map_or(999.0, |f| f.0)).collect();
            println!("{i} {fraction} {w:?}: error {:.2}/{:.2} detected {:.2}/{:.2} right {right}/{} early {}", quantile(&e, 0.5), quantile(&e, 0.95), quantile(&t, 0.5), quantile(&t, 0.95), runs.len(), t.iter().filter(|t| **t < 0.0).count());
        }
    }
}
#[test]
fn speed() {
    let o = Options::nominal(Course::BE3, 1);
    let m = fly(&o);
    let cpu = || { let s = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap(); s.split(' ').next().unwrap().parse::<f64>().unwrap() };
    for w in ALL {
        let t = cpu();
        for _ in 0..3 { run(w, &o, &m, |_| {}); }
        println!("{w:?} {:.1} ms a mission, {:.2} us per 0.1 s", (cpu() - t) / 3e6, (cpu() - t) / 3e3 / m.truth.len() as f64);
    }
    println!("events {} truth {}", m.events.len(), m.truth.len());
}
#[test]
fn one() {
    let o = Options { duration_s: 60.0, ..Options::nominal(Course::BE3, 1) };
    let m = fly(&o);
    let w = match std::env::var("WHICH").as_deref() { Ok("dyn") => Which::Dynamic, Ok("ma") => Which::ModelAided, _ => Which::Inertial };
    run(w, &o, &m, |_| {});
}
#[test]
fn river() {
    use rexrov::estimation::*;
    let text = std::fs::read_to_string("/tmp/river.csv").unwrap();
    let rows: Vec<Vec<f64>> = text.lines().map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    for (name, fixes, bias) in [("dr", false, 0.1), ("fix", true, 0.2), ("dr nobias", false, 0.0)] {
        let mut p = NavigationParameters::default();
        p.mounting.dvl = [0.0; 3];
        p.mounting.pressure = [0.0; 3];
        p.sensors.heading_bias_sigma = bias;
        p.sensors.dvl_sigma = std::env::var("DS").map_or(0.03, |s| s.parse().unwrap());
        p.sensors.dvl_scale_sigma = 0.01;
        p.sensors.fix_sigma = 2.0;
        p.start.position = [0.0; 3];
        let v = rexrov::vehicle::Parameters::default();
        let d = Disturbances::default();
        fn go(name: &str, f: &impl Navigation, rows: &[Vec<f64>], fixes: bool) {
            let mut m = f.memory();
            let mut u = Measurements::default();
            let mut last = Estimate::default();
            for r in rows {
                u.ahrs = Reading::at(r[0], [r[1], r[2], r[3]]);
                if r[4] > 0.5 { u.dvl = Reading::at(r[0], [r[5], r[6], r[7]]); }
                if fixes { u.fix = Reading::at(r[0], [r[8], r[9], 0.0]); }
                let e = f.update(&mut m, r[0], &u);
                if name == "dr ins" && e.channels[1].innovation[0].abs() > 1e-3 { println!("t {} innov {:.4} sigma {:.4} rate {:.3?} rej {} inv {:?}", r[0], e.channels[1].innovation[0], e.channels[1].sigma[0], e.rate, e.channels[1].rejected, last.health); }
                last = e;
            }
            let r = rows.last().unwrap();
            println!("{name}: pos {:.2?} gps {:.2} {:.2} sigma {:.2} {:.2} vel {:.2?} health {:?} used {:?} rejected {:?} nis {:.1?}", last.position, r[8], r[9], last.covariance[0][0].sqrt(), last.covariance[1][1].sqrt(), last.velocity, last.health, last.channels.map(|c| c.used), last.channels.map(|c| c.rejected), last.channels.map(|c| c.nis));
        }
        go(&format!("{name} ca"), &Filter::<_, 19>::new(ConstantAcceleration::new(&p).unwrap(), &p).unwrap(), &rows, fixes);
        go(&format!("{name} dyn"), &DynamicFilter::new(PlanarDynamic::new(&p, &v, &d).unwrap(), &p).unwrap(), &rows, fixes);
        go(&format!("{name} ins"), &Filter::<_, 19>::new(InertialProcess::new(&p, None).unwrap(), &p).unwrap(), &rows, fixes);
        go(&format!("{name} ma"), &AidedFilter::new(&p, &v, &d).unwrap(), &rows, fixes);
    }
}
