//! Facts about every filter, and properties of an estimate at any time.

use proptest::prelude::*;
use rexrov::estimation::*;
use rexrov::vehicle::Parameters;

pub(super) type Check = Result<(), TestCaseError>;

/// Something that is true of every filter.
pub(super) trait Fact {
    fn check<F: Navigation<Memory = Memory<N, M>>, const N: usize, M: Copy>(
        &self,
        filter: &F,
    ) -> Check;
}

/// Checks it with all of them; `extra`: with all sensor states.
pub(super) fn for_all(fact: &impl Fact, extra: bool) -> Check {
    let mut p = NavigationParameters::default();
    if extra {
        p.sensors.dvl_scale_sigma = 0.01;
        p.sensors.dvl_misalignment_sigma = 0.02;
        p.sensors.dvl_delay_sigma = 0.05;
    } else {
        p.sensors.heading_bias_sigma = 0.0;
    }
    let (vehicle, d) = (Parameters::default(), Disturbances::default());
    let aid = ModelAid::new(&vehicle, &ModelErrors::default()).unwrap();
    let constant = ConstantAcceleration::new(&p).unwrap();
    let planar = PlanarDynamic::new(&p, &vehicle, &d).unwrap();
    fact.check(&ConstantAccelerationFilter::new(constant, &p).unwrap())?;
    fact.check(&UnmonitoredDynamicFilter::new(planar.clone(), &p).unwrap())?;
    fact.check(&DynamicFilter::new(planar, &p).unwrap())?;
    fact.check(&InertialFilter::new(InertialProcess::new(&p, None).unwrap(), &p).unwrap())?;
    fact.check(
        &UnmonitoredAidedFilter::new(InertialProcess::new(&p, Some(aid)).unwrap(), &p).unwrap(),
    )
}

/// Properties that hold at any time.
pub(super) fn sound<const N: usize, M>(estimate: &Estimate, memory: &Memory<N, M>) -> Check {
    let e = estimate;
    let scalars = [e.position, e.euler, e.velocity, e.rate, e.acceleration, e.velocity_sigma];
    let channels = e.channels.iter().flat_map(|c| c.innovation.iter().chain(&c.sigma));
    let all = scalars.iter().flatten().chain(&e.current).chain(&e.loss).chain(channels);
    prop_assert!(all.chain(e.covariance.iter().flatten()).all(|x| x.is_finite()), "{:?}", e);
    prop_assert!(e.channels.iter().all(|c| !c.nis.is_nan() && c.nis >= 0.0), "{:?}", e.channels);
    for i in 0..6 {
        prop_assert!(e.covariance[i][i] >= 0.0, "variance {i}: {}", e.covariance[i][i]);
        for j in 0..i {
            prop_assert_eq!(e.covariance[i][j], e.covariance[j][i]);
        }
    }
    let Some(belief) = memory.belief() else { return Ok(()) };
    let p = &belief.covariance;
    prop_assert!(belief.is_finite());
    for i in 0..belief.order() {
        prop_assert!(p[(i, i)] >= 0.0, "variance of state {i}: {}", p[(i, i)]);
        for j in 0..i {
            let size = (p[(i, i)] * p[(j, j)]).sqrt();
            let skew = (p[(i, j)] - p[(j, i)]).abs();
            prop_assert!(skew <= 1e-9 * size, "P[{i}][{j}] is not symmetric: {skew} of {size}");
        }
    }
    prop_assert!(belief.is_positive(), "P is not positive: {}", least_pivot(belief));
    Ok(())
}

/// The smallest pivot of the correlation matrix, and its state.
fn least_pivot<const N: usize>(belief: &belief::Belief<N>) -> String {
    let n = belief.order();
    let sigma = |i: usize| belief.covariance[(i, i)].sqrt();
    let scaled = |i: usize, j: usize| belief.covariance[(i, j)] / (sigma(i) * sigma(j));
    let mut rest = nalgebra::DMatrix::from_fn(n, n, scaled);
    let mut least = (f64::INFINITY, 0);
    for k in 0..n {
        let pivot = rest[(k, k)];
        if pivot < least.0 {
            least = (pivot, k);
        }
        if pivot > 1e-14 {
            for i in k + 1..n {
                for j in k + 1..n {
                    rest[(i, j)] -= rest[(i, k)] * rest[(k, j)] / pivot;
                }
            }
        }
    }
    format!(
        "pivot {} of state {}, sigmas {:?}",
        least.0,
        least.1,
        (0..n).map(sigma).collect::<Vec<_>>()
    )
}
