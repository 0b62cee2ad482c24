//! Every F and every H of the navigation filters against dual numbers.
//!
//! The dual numbers run through `oracle`, an independent implementation of the processes and
//! sensors. Errors are defined as in the filters: an attitude is `q Exp(dtheta)`, differentiated at
//! zero.

#[path = "../oracle/estimation/mod.rs"]
mod oracle;

mod cases;
mod compare;
mod draw;

use cases::*;
use compare::*;
use oracle::*;
use proptest::prelude::*;
use rexrov::estimation::interval::Interval;
use rexrov::estimation::process::Process;
use rexrov::estimation::process::model_aid::AidStates;

const SMALL: usize = 19;
const LARGE: usize = 33;
const TOLERANCE: f64 = 1e-9;

type Check = Result<(), TestCaseError>;

fn numbers() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0, 240)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn inertial_prediction(numbers in numbers()) {
        Strapdown::<SMALL>::new(&numbers, false, true).prediction()?;
    }

    #[test]
    fn inertial_prediction_with_aid(numbers in numbers()) {
        Strapdown::<LARGE>::new(&numbers, true, true).prediction()?;
    }

    #[test]
    fn inertial_prediction_without_inertial_unit(numbers in numbers()) {
        Strapdown::<SMALL>::new(&numbers, false, false).prediction()?;
        Strapdown::<LARGE>::new(&numbers, true, false).prediction()?;
    }

    #[test]
    fn planar_prediction(numbers in numbers()) {
        for thrust in [true, false] {
            let case = Planar::new(&numbers, thrust);
            let (mut predicted, mut tape) = (case.belief, Tape::default());
            case.process.predict(&mut predicted, &case.interval, &mut tape);
            let time = case.d.correlation_time;
            let mean = case.mean();
            predicted.attitude = mean.q;
            close_points(&predicted, &case.hull.planar(&mean, &case.interval, time), Some(3))?;
            let want = mean.transition(|m| case.hull.planar(m, &case.interval, time));
            prop_assert_eq!(tape.transitions.len(), 1);
            close_rows("F", &rows_of(&tape.transitions[0]), &want, SMALL)?;
        }
    }

    #[test]
    fn constant_acceleration_prediction(numbers in numbers()) {
        let case = Constant::new(&numbers);
        let (mut predicted, mut tape) = (case.belief, Tape::default());
        case.process.predict(&mut predicted, &case.interval, &mut tape);
        let (mean, dt) = (case.mean(), case.interval.dt);
        close_points(&predicted, &constant_acceleration(&mean, dt), None)?;
        let want = mean.transition(|m| constant_acceleration(m, dt));
        close_rows("F", &rows_of(&tape.transitions[0]), &want, SMALL)?;
    }

    #[test]
    fn sensors_by_the_inertial_process(numbers in numbers()) {
        for imu in [true, false] {
            Strapdown::<SMALL>::new(&numbers, false, imu).sensors()?;
            Strapdown::<LARGE>::new(&numbers, true, imu).sensors()?;
        }
    }

    #[test]
    fn sensors_by_the_planar_process(numbers in numbers()) {
        for thrust in [true, false] {
            Planar::new(&numbers, thrust).sensors()?;
        }
    }

    #[test]
    fn sensors_by_constant_acceleration(numbers in numbers()) {
        Constant::new(&numbers).sensors()?;
    }

    #[test]
    fn gyro_of_the_planar_process(numbers in numbers()) {
        let case = Planar::new(&numbers, true);
        let seen = case.process.gyro(&case.belief, &case.interval, 0.0);
        close_observation("gyro", &seen, SMALL, &case.mean(), |m| case.hull.gyro(m, &case.interval))?;
    }

    #[test]
    fn force_balance(numbers in numbers()) {
        let case = Strapdown::<LARGE>::new(&numbers, true, true);
        let Interval { inertial, thrust, dt, .. } = case.interval;
        let imu = inertial.unwrap();
        let at = AidStates::at(BASE);
        let mut seen = case.aid.force_balance(&case.belief, at, &imu, &thrust.unwrap(), dt);
        (0..3).for_each(|i| seen.innovation[i] -= imu.specific_force[i]);
        close_observation("force", &seen, case.order, &case.mean(), |m| case.hull.force(m, &case.interval))?;
    }

    #[test]
    fn moment_balance(numbers in numbers()) {
        let case = Strapdown::<LARGE>::new(&numbers, true, true);
        let [before, now] = [case.before, case.interval]
            .map(|i| (i.inertial.unwrap(), i.thrust.unwrap(), i.dt));
        let pair = [(&before.0, &before.1, before.2), (&now.0, &now.1, now.2)];
        let mut seen = case.aid.moment_balance(&case.belief, AidStates::at(BASE), pair);
        seen.innovation[0] -= (now.0.rate[2] - before.0.rate[2]) * 2.0 / (before.2 + now.2);
        close_observation("moment", &seen, case.order, &case.mean(),
            |m| case.hull.moment(m, &case.before, &case.interval))?;
    }

    #[test]
    fn gyros_and_accelerometers_by_constant_acceleration(numbers in numbers()) {
        let case = Constant::new(&numbers);
        let (mut belief, mut tape) = (case.belief, Tape::default());
        case.process.aid(&mut belief, &case.interval, &case.interval, &mut tape);
        let mean = case.mean();
        close_rows("gyros", &tape.rows[..3], &mean.rows(|m| constant_acceleration_motion(m).rate), SMALL)?;
        let want = mean.rows(|m| constant_acceleration_force(m, &case.p));
        close_rows("accelerometers", &tape.rows[3..], &want, SMALL)?;
    }
}
