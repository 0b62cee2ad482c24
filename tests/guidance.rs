//! Courses and the path follower.

use approx::assert_relative_eq;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use proptest::prelude::*;
use rexrov::guidance::*;

fn courses() -> [Course; 5] {
    Course::BUILT_IN.map(|(_, text)| Course::parse(text).unwrap())
}

fn corner(x: f64, y: f64, radius: f64) -> Waypoint {
    Waypoint { x, y, radius, z: None }
}

#[test]
fn the_courses_have_their_lengths_and_ends() {
    let expected = [
        (57.85, [40.0, 20.0]),
        (88.54, [60.0, 10.0]),
        (96.42, [25.0, 40.0]),
        (169.27, [40.0, 60.0]),
        (36.0 * PI, [0.0, 0.0]),
    ];
    for (course, (length, end)) in courses().iter().zip(expected) {
        assert_relative_eq!(course.length(), length, epsilon = 0.005);
        let ([north, east], heading) = (course.point(0.0), course.heading(0.0));
        assert!(north.abs() + east.abs() + heading.abs() < 1e-12, "{north} {east} {heading}");
        let [x, y] = course.point(course.length());
        assert_relative_eq!(x, end[0], epsilon = 1e-9);
        assert_relative_eq!(y, end[1], epsilon = 1e-9);
    }
}

#[test]
fn a_course_is_continuous_and_smooth_but_for_its_sharp_corners() {
    for course in courses() {
        let steps = (course.length() / 1e-3) as usize;
        let sharp = (1..steps).filter(|&i| {
            let s = i as f64 * 1e-3;
            let (a, b) = (course.point(s), course.point(s + 1e-3));
            let chord = (b[0] - a[0]).hypot(b[1] - a[1]);
            assert!(chord <= 1e-3 + 1e-9, "jump at {s}");
            rexrov::attitude::wrap(course.heading(s + 1e-3) - course.heading(s)).abs() > 0.01
        });
        // Only BE1 has one, at (25, 20).
        let expected = usize::from(course.length() < 60.0);
        assert_eq!(sharp.count(), expected);
    }
}

#[test]
fn beyond_its_ends_a_course_goes_on_straight() {
    let course = &courses()[0];
    let end = course.point(course.length() + 2.0);
    assert_relative_eq!(end[0], 42.0, epsilon = 1e-9);
    assert_relative_eq!(end[1], 20.0, epsilon = 1e-9);
    assert_eq!(course.point(-1.0), [-1.0, 0.0]);
    assert_eq!(course.nearest([-5.0, 1.0], -10.0, 10.0), 0.0);
    assert_relative_eq!(course.nearest([99.0, 20.0], 0.0, 1e3), course.length());
}

#[test]
fn cross_track_is_positive_to_starboard() {
    let course = &courses()[0];
    assert_relative_eq!(course.cross_track([5.0, 0.7], 5.0), 0.7);
    assert_relative_eq!(course.cross_track([5.0, -0.7], 5.0), -0.7);
    // Outside of the first turn, which goes to starboard around (20, 5).
    let p = [20.0 + 6.0 * FRAC_PI_4.cos(), 5.0 - 6.0 * FRAC_PI_4.sin()];
    let s = course.nearest(p, 0.0, 30.0);
    assert_relative_eq!(s, 20.0 + 5.0 * FRAC_PI_4, epsilon = 1e-9);
    assert_relative_eq!(course.cross_track(p, s), -1.0, epsilon = 1e-9);
}

proptest! {
    #[test]
    fn nearest_finds_what_a_dense_scan_finds(
        which in 0..5_usize, x in -5.0..65.0_f64, y in -5.0..45.0_f64,
        from in 0.0..90.0_f64, span in 0.1..40.0_f64
    ) {
        let course = &courses()[which];
        let distance = |s: f64| {
            let p = course.point(s);
            f64::hypot(p[0] - x, p[1] - y)
        };
        let (low, high) = (from.min(course.length()), (from + span).min(course.length()));
        let found = course.nearest([x, y], from, from + span);
        prop_assert!((low..=high).contains(&found), "{found} not in {low}..{high}");
        let scan = (0..=4000).map(|i| distance(low + (high - low) * f64::from(i) / 4000.0));
        let best = scan.fold(f64::INFINITY, f64::min);
        prop_assert!(distance(found) <= best + 1e-9, "{} > {best}", distance(found));
    }

    #[test]
    fn any_polygon_with_small_enough_radii_is_a_course(
        steps in prop::collection::vec((2.0..20.0_f64, -2.5..2.5_f64), 1..12), radius in 0.0..0.3
    ) {
        let mut points = vec![corner(0.0, 0.0, 0.0)];
        let mut course = 0.0;
        for (length, turn) in steps {
            course += turn;
            let last = points[points.len() - 1];
            let (x, y) = (last.x + length * f64::cos(course), last.y + length * f64::sin(course));
            points.push(corner(x, y, radius));
        }
        let corners: f64 = points.windows(2).map(|w| f64::hypot(w[1].x - w[0].x, w[1].y - w[0].y)).sum();
        let course = Course::new(&points).unwrap();
        prop_assert!(course.length() <= corners + 1e-9);
        let (end, last) = (course.point(course.length()), points[points.len() - 1]);
        prop_assert!((end[0] - last.x).hypot(end[1] - last.y) < 1e-9);
    }
}

/// The waypoints of a course with depths, all its corners rounded.
fn dive() -> impl Strategy<Value = Vec<Waypoint>> {
    let step = (8.0..30.0_f64, -2.0..2.0_f64, 0.1..2.0_f64, 0.0..50.0_f64);
    prop::collection::vec(step, 1..10).prop_map(|steps| {
        let mut points = vec![Waypoint { z: Some(20.0), ..Waypoint::default() }];
        let mut course = 0.0_f64;
        for (length, turn, radius, z) in steps {
            course += turn;
            let last = points[points.len() - 1];
            let (x, y) = (last.x + length * course.cos(), last.y + length * course.sin());
            points.push(Waypoint { x, y, radius, z: Some(z) });
        }
        points
    })
}

proptest! {
    #[test]
    fn a_course_passes_its_waypoints_at_their_depths_and_is_linear_between(points in dive()) {
        let course = Course::new(&points).unwrap();
        let mut before = (0.0, 20.0);
        for (last, point) in points.iter().zip(&points[1..]) {
            // No more than the length of the leg ahead; on an arc its middle is nearest.
            let leg = (point.x - last.x).hypot(point.y - last.y);
            let near = course.nearest([point.x, point.y], before.0, before.0 + leg);
            let z = point.z.unwrap();
            prop_assert!((course.depth(near).unwrap() - z).abs() < 1e-6, "{near} {points:?}");
            let at = |part: f64| before.0 + part * (near - before.0);
            let middle = course.depth(at(0.3)).unwrap();
            prop_assert!((middle - (0.7 * before.1 + 0.3 * z)).abs() < 1e-6);
            before = (near, z);
        }
        prop_assert_eq!(course.depth(-1.0), Some(20.0));
        prop_assert_eq!(course.depth(course.length() + 1.0), points[points.len() - 1].z);
    }

    #[test]
    fn depth_and_slope_are_continuous(points in dive(), s in -1.0..200.0_f64) {
        let course = Course::new(&points).unwrap();
        let step = |f: &dyn Fn(f64) -> Option<f64>| f(s + 1e-6).unwrap() - f(s).unwrap();
        // Legs are longer than 4 m between their waypoints, depths at most 50 m apart.
        prop_assert!(step(&|s| course.depth(s)).abs() < 1.3e-5);
        prop_assert!(step(&|s| course.slope(s, 1.0)).abs() < 2.6e-5);
    }
}

fn message(text: &str) -> String {
    Course::parse(text).unwrap_err().to_string()
}

#[test]
fn bad_courses_say_where_and_why() {
    assert_eq!(message(""), "course: needs at least two points, has 0");
    assert_eq!(message("x,y\n1,2\n"), "course: needs at least two points, has 1");
    assert_eq!(message("0,0\n\n# comment\n1,north\n"), "line 4: y = `north` is not a number");
    assert!(message("0,0\n1\n").starts_with("line 2: expected `x,y`, `x,y,radius` or"));
    assert!(message("0,0\n1,0\n1,0 # again\n").starts_with("line 3: (1, 0) repeats"));
    assert!(message("0,0\nnan,0\n").starts_with("line 2: (NaN, 0, 0) must be finite"));
    assert!(message("0,0\n9,0,-1\n9,9\n").starts_with("line 2: radius -1 must not"));
    assert!(message("0,0\n9,0,1\n0,0\n").starts_with("line 2: turns back on itself"));
    assert_eq!(message("0,0,0,1\n9,0,0,deep\n"), "line 2: z = `deep` is not a number");
    assert!(message("0,0,0,1\n9,0,0,inf\n").starts_with("line 2: depth z = inf must be"));
    let some = ["0,0,0,9\n1,0,0,9\n2,0\n", "0,0\n1,0\n2,0,0,9\n"].map(message);
    assert!(some[0].starts_with("line 3: has no depth z, but the first point has one"), "{some:?}");
    assert!(some[1].starts_with("line 3: has a depth z, but the first point has none"), "{some:?}");
    let reason = message("x,y,radius\n0,0\n10,0,6\n10,10,6\n0,10\n");
    assert!(reason.starts_with("line 3: radius 6 is too large"), "{reason}");
    assert!(reason.contains("(10, 0) to (10, 10) take 12.000000 m of it"), "{reason}");
}

#[test]
fn courses_read_headers_comments_and_missing_radii() {
    let a =
        Course::parse("# survey\n X , Y, Radius\r\n 0, 0\r\n 10, 0, 2 # corner\r\n10,10").unwrap();
    let b = Course::new(&[corner(0.0, 0.0, 0.0), corner(10.0, 0.0, 2.0), corner(10.0, 10.0, 0.0)]);
    assert_eq!(a, b.unwrap());
    assert_relative_eq!(a.length(), 16.0 + PI, epsilon = 1e-12);
}

fn pursuit(p: &PursuitParameters, course: &str) -> PurePursuit {
    PurePursuit::new(p, Course::parse(course).unwrap()).unwrap()
}

/// A vehicle that follows commands exactly, for `seconds`; the largest distance from the course.
fn follow(pursuit: &PurePursuit, mut pose: [f64; 4], seconds: usize) -> (Guidance, f64) {
    let mut memory = PursuitMemory::default();
    let (mut last, mut worst) = (Guidance::default(), 0.0);
    for _ in 0..10 * seconds {
        last = pursuit.update(&mut memory, pose);
        worst = f64::max(worst, last.cross_track.hypot(last.vertical_track));
        let [u, _, w, r] = last.command;
        pose[0] += 0.1 * u * pose[3].cos();
        pose[1] += 0.1 * u * pose[3].sin();
        pose[2] += 0.1 * w;
        pose[3] = rexrov::attitude::wrap(pose[3] + 0.1 * r);
    }
    (last, worst)
}

#[test]
fn an_ideal_vehicle_finishes_every_course_close_to_it() {
    for (_, text) in Course::BUILT_IN {
        let pursuit = pursuit(&PursuitParameters::default(), text);
        let (end, worst) = follow(&pursuit, [0.0, 0.0, 20.0, 0.0], 600);
        assert!(end.finished && worst < 0.5, "{worst} {end:?}");
        assert_eq!(end.command[0], 0.0);
        let (end, _) = follow(&pursuit, [-0.5, 1.0, 21.0, 2.0], 600);
        assert!(end.finished, "{end:?}");
    }
}

#[test]
fn the_printed_alpha_does_not_correct_a_distance_from_the_course() {
    let straight = "0,0\n1000,0\n";
    let start = [0.0, 1.0, 20.0, 0.0];
    let printed =
        PursuitParameters { heading_reference: HeadingReference::Segment, ..Default::default() };
    let (end, _) = follow(&pursuit(&printed, straight), start, 60);
    assert_relative_eq!(end.cross_track, 1.0, epsilon = 1e-9);
    let (end, _) = follow(&pursuit(&PursuitParameters::default(), straight), start, 60);
    assert!(end.cross_track.abs() < 1e-3);
}

#[test]
fn turn_rate_follows_equations_54_and_55_and_stays_bounded() {
    let pursuit = pursuit(&PursuitParameters::default(), "0,0\n1000,0\n");
    let rate =
        |yaw: f64| pursuit.update(&mut PursuitMemory::default(), [0.0, 0.0, 20.0, yaw]).command[3];
    assert_relative_eq!(rate(-0.2), 0.3 * (2.0 * 0.2_f64.sin()).atan(), epsilon = 1e-12);
    assert_relative_eq!(rate(-FRAC_PI_2), 0.332, epsilon = 2e-4);
    // Facing away the tightest turn remains; the sine alone would go to zero.
    assert_relative_eq!(rate(3.1), -0.332, epsilon = 2e-4);
}

#[test]
fn depth_error_commands_a_limited_heave() {
    let pursuit = pursuit(&PursuitParameters::default(), "0,0\n1000,0\n");
    let heave =
        |z: f64| pursuit.update(&mut PursuitMemory::default(), [0.0, 0.0, z, 0.0]).command[2];
    assert_relative_eq!(heave(19.8), 0.04, epsilon = 1e-12);
    assert_relative_eq!(heave(0.0), 0.1);
    assert_relative_eq!(heave(50.0), -0.1);
}

#[test]
fn on_a_level_course_the_depth_is_the_parameter() {
    let course = Course::parse("0,0\n1000,0\n").unwrap();
    assert_eq!((course.depth(5.0), course.slope(5.0, 1.0)), (None, None));
    let seen = PurePursuit::new(&PursuitParameters::default(), course)
        .unwrap()
        .update(&mut PursuitMemory::default(), [5.0, 0.0, 20.5, 0.0]);
    assert_eq!((seen.target[2], seen.vertical_track), (20.0, 0.5));
}

#[test]
fn heave_follows_the_slope_and_corrects_within_its_limit() {
    let pursuit = pursuit(&PursuitParameters::default(), "0,0,0,10\n100,0,0,30\n");
    // 0.5 m below the course at x = 1, whose slope is 0.2; the target 1 m ahead.
    let at = |z| pursuit.update(&mut PursuitMemory::default(), [1.0, 0.0, z, 0.0]);
    assert_relative_eq!(at(10.7).target[2], 10.4, epsilon = 1e-12);
    assert_relative_eq!(at(10.7).vertical_track, 0.5, epsilon = 1e-12);
    assert_relative_eq!(at(10.7).command[2], 0.3 * 0.2 - 0.2 * 0.5, epsilon = 1e-12);
    assert_relative_eq!(at(0.0).command[2], 0.3 * 0.2 + 0.1, epsilon = 1e-12);
}

#[test]
fn the_whole_heave_command_has_a_limit_of_its_own() {
    let steep = pursuit(&PursuitParameters::default(), "0,0,0,10\n100,0,0,300\n");
    let seen = steep.update(&mut PursuitMemory::default(), [1.0, 0.0, 12.9, 0.0]);
    assert_eq!(seen.command[2], 0.3);
}

#[test]
fn a_kink_in_the_depth_changes_the_heave_command_over_one_lookahead() {
    let p = PursuitParameters { search_ahead: 20.0, ..Default::default() };
    let pursuit = pursuit(&p, "0,0,0,10\n10,0,0,14\n20,0,0,10\n");
    let heave = |x: f64| {
        let z = pursuit.course().depth(x).unwrap();
        pursuit.update(&mut PursuitMemory::default(), [x, 0.0, z, 0.0]).command[2]
    };
    let slopes = [(9.4, 0.4), (9.75, 0.2), (10.0, 0.0), (10.25, -0.2), (10.6, -0.4)];
    for (x, slope) in slopes {
        assert_relative_eq!(heave(x), 0.3 * slope, epsilon = 1e-12);
    }
}

#[test]
fn the_search_window_keeps_to_its_leg_where_the_course_meets_itself() {
    // Two legs 0.5 m apart; the vehicle is on the first, a little nearer to the second.
    let pursuit = pursuit(&PursuitParameters::default(), "0,0\n50,0\n50,0.5\n0,0.5\n");
    let mut memory = PursuitMemory::default();
    for i in 0..100 {
        let x = 0.1 * f64::from(i);
        let seen = pursuit.update(&mut memory, [x, 0.3, 20.0, 0.0]);
        assert_relative_eq!(seen.distance, x, epsilon = 1e-9);
    }
}
