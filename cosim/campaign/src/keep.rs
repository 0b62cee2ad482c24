//! The runs of a campaign whose trajectories are kept.

use super::file::Keep;
use super::{Campaign, Rows, Status};
use cosim_base::error::Result;

/// The numbers of these runs, in ascending order.
pub fn kept(campaign: &Campaign, rows: &Rows) -> Result<Vec<u64>> {
    let keep = &campaign.keep;
    if *keep == Keep::default() {
        return Ok(Vec::new());
    }
    // Where large values are good, small ones are the worst.
    let more = campaign.verdicts.iter().any(|t| t.figure == keep.figure && t.least.is_some());
    let figure = rows.figure(keep.figure)?;
    let badness = |at: usize| match figure[at] {
        value if value.is_nan() => f64::INFINITY,
        value if more => -value,
        value => value,
    };
    let mut kept: Vec<usize> = Vec::new();
    for own in rows.by_cell(campaign, campaign.runs()) {
        let (mut good, failed): (Vec<usize>, Vec<usize>) =
            own.into_iter().partition(|at| rows.is_good(*at));
        kept.extend(good.iter().take(keep.sample));
        good.sort_by(|one, other| badness(*other).total_cmp(&badness(*one)));
        kept.extend(good.iter().take(keep.worst));
        // A run that timed out would do so again.
        let again = |at: &&usize| keep.failed && rows.status(**at) != Status::TimedOut;
        kept.extend(failed.iter().filter(again));
    }
    let mut kept: Vec<u64> = kept.into_iter().map(|at| rows.runs()[at]).collect();
    kept.sort_unstable();
    kept.dedup();
    Ok(kept)
}
