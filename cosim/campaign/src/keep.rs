//! The runs of a campaign whose trajectories are kept.

use super::file::Keep;
use super::{Campaign, Row, Status};

/// The numbers of these runs, in ascending order.
pub fn kept(campaign: &Campaign, rows: &[Row]) -> Vec<u64> {
    let keep = &campaign.keep;
    if *keep == Keep::default() {
        return Vec::new();
    }
    // Where large values are good, small ones are the worst.
    let more = campaign.verdicts.iter().any(|t| t.figure == keep.figure && t.least.is_some());
    let badness = |row: &&Row| {
        let value = row.figure(keep.figure);
        if value.is_nan() {
            f64::INFINITY
        } else if more {
            -value
        } else {
            value
        }
    };
    let mut kept = Vec::new();
    for cell in 0..campaign.cells() {
        let own = rows
            .iter()
            .filter(|row| row.run < campaign.runs() && campaign.cell_of(row.run) == cell);
        let (mut good, failed): (Vec<&Row>, Vec<&Row>) = own.partition(|r| r.status == Status::Ok);
        good.sort_by_key(|row| row.run);
        kept.extend(good.iter().take(keep.sample).map(|row| row.run));
        good.sort_by(|one, other| badness(other).total_cmp(&badness(one)));
        kept.extend(good.iter().take(keep.worst).map(|row| row.run));
        // A run that timed out would do so again.
        let over = failed.iter().filter(|row| keep.failed && row.status != Status::TimedOut);
        kept.extend(over.map(|row| row.run));
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}
