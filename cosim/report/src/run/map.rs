//! The map: paths at the same instants, and the uncertainty of the estimates.

use serde::Serialize;

use super::columns::Columns;
use super::plots::Role;
use super::thin;
use crate::numbers::Numbers;
use crate::units::Units;
use cosim_results::roles::{Estimate, Paths};

/// Paths in a horizontal plane; x is north, y is east.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Map {
    t: Numbers,
    paths: Vec<Path>,
}

#[derive(Debug, Clone, Serialize)]
struct Path {
    name: String,
    role: Role,
    x: Numbers,
    y: Numbers,
    #[serde(skip_serializing_if = "Option::is_none")]
    z: Option<Numbers>,
    /// In radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw: Option<Numbers>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ellipses: Option<Ellipses>,
}

/// Covariances of x and y at some instants.
#[derive(Debug, Clone, Serialize)]
struct Ellipses {
    /// Positions among the instants of the map.
    at: Vec<usize>,
    xx: Numbers,
    xy: Numbers,
    yy: Numbers,
}

/// Ellipses of one path, and position fixes.
const ELLIPSES: usize = 60;
const FIXES: usize = 300;

impl Map {
    /// With at most this many instants; `None` without a path.
    pub(super) fn of(
        columns: &Columns<'_>,
        paths: &Paths,
        units: &Units,
        instants: usize,
    ) -> Option<Self> {
        let places = thin::even(columns.time.len(), instants);
        let made = super::paths_of(paths).filter_map(|(name, role)| {
            let times = |leaf: &str, factor: &dyn Fn(&str) -> f64| {
                let column = format!("{name}.{leaf}");
                let (values, factor) = (columns.get(&column)?, factor(&column));
                Some(Numbers::values(places.iter().map(|&place| factor * values[place])))
            };
            let pick = |leaf: &str| times(leaf, &|_| 1.0);
            Some(Path {
                x: pick("x")?,
                y: pick("y")?,
                z: pick("z"),
                yaw: times("yaw", &|column| units.radians(column)),
                ellipses: paths
                    .estimates
                    .iter()
                    .find(|estimate| estimate.path == name)
                    .and_then(|estimate| ellipses(columns, estimate, &places)),
                role,
                name: name.to_owned(),
            })
        });
        let mut made: Vec<Path> = made.collect();
        made.extend(paths.fixes.iter().filter_map(|name| fixes(columns, name)));
        if made.is_empty() || columns.time.is_empty() {
            return None;
        }
        let t = Numbers::times(places.iter().map(|&place| columns.time[place]));
        Some(Self { t, paths: made })
    }
}

fn ellipses(columns: &Columns<'_>, estimate: &Estimate, places: &[usize]) -> Option<Ellipses> {
    let sigma = estimate.sigma.as_ref()?;
    let deviation = |axis: &str| columns.get(&format!("{sigma}.{axis}"));
    let (x, y) = (deviation("x")?, deviation("y")?);
    let both = estimate.covariance.as_ref().and_then(|c| columns.get(&format!("{c}.x_y")));
    let at = thin::even(places.len(), ELLIPSES);
    let of = |value: &dyn Fn(usize) -> f64| {
        Numbers::values(at.iter().map(|&place| value(places[place])).collect::<Vec<_>>())
    };
    Some(Ellipses {
        xx: of(&|row| x[row] * x[row]),
        xy: of(&|row| both.as_ref().map_or(0.0, |both| both[row])),
        yy: of(&|row| y[row] * y[row]),
        at,
    })
}

/// The positions where a fix differs from the previous one: held values are not drawn again.
fn fixes(columns: &Columns<'_>, name: &str) -> Option<Path> {
    let (x, y) = (columns.get(&format!("{name}.x"))?, columns.get(&format!("{name}.y"))?);
    let new = |row: &usize| {
        let known = x[*row].is_finite() && y[*row].is_finite();
        known && *row > 0 && (x[*row], y[*row]) != (x[*row - 1], y[*row - 1])
    };
    let rows: Vec<usize> = (0..x.len()).filter(new).collect();
    let shown = thin::even(rows.len(), FIXES);
    let pick = |of: &[f64]| Numbers::values(shown.iter().map(|&i| of[rows[i]]).collect::<Vec<_>>());
    let (x, y) = (pick(&x), pick(&y));
    let (name, role) = (name.to_owned(), Role::Fix);
    (!rows.is_empty()).then_some(Path { name, role, x, y, z: None, yaw: None, ellipses: None })
}
