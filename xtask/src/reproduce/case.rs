//! How runs differ: course, filter, accuracy of the position fix, seed.

use std::fmt;

use rexrov::guidance::Course as Path;

/// A test course of the paper, section 9.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Course {
    /// Straight, fixed turn, sharp turn (Fig. 6, Table 7).
    Be1,
    /// Constant-radius sinusoid (Fig. 7, Table 8).
    Be2,
    /// U shapes, clockwise and counter-clockwise (Fig. 8, Table 9).
    Be3,
}

impl Course {
    /// All courses in the paper's order.
    pub(crate) const ALL: [Course; 3] = [Course::Be1, Course::Be2, Course::Be3];

    /// The short name, also the item of the guidance component's parameter.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Course::Be1 => "BE1",
            Course::Be2 => "BE2",
            Course::Be3 => "BE3",
        }
    }

    /// The purpose of the course.
    pub(crate) fn description(self) -> &'static str {
        match self {
            Course::Be1 => "straight, fixed turn, sharp turn",
            Course::Be2 => "constant-radius sinusoid",
            Course::Be3 => "U shapes, clockwise and counter-clockwise",
        }
    }

    /// Its number, 1 to 3: table 7 and figure 6 belong to the first.
    pub(crate) fn number(self) -> usize {
        self as usize + 1
    }

    /// The reference path.
    pub(crate) fn path(self) -> anyhow::Result<Path> {
        let corners = match self {
            Course::Be1 => Path::BE1,
            Course::Be2 => Path::BE2,
            Course::Be3 => Path::BE3,
        };
        Ok(Path::parse(corners)?)
    }
}

/// A filter of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Filter {
    /// Acceleration from the dynamic model, eqs 27 to 30.
    Dynamic,
    /// Acceleration from the IMU.
    Kinematic,
}

impl Filter {
    /// Both, in the order of the paper's columns.
    pub(crate) const ALL: [Filter; 2] = [Filter::Dynamic, Filter::Kinematic];

    /// The name in tables and file names.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Filter::Dynamic => "dynamic",
            Filter::Kinematic => "kinematic",
        }
    }

    /// Its FMU.
    pub(crate) fn fmu(self) -> &'static str {
        match self {
            Filter::Dynamic => "EkfDynamic.fmu",
            Filter::Kinematic => "EkfKinematic.fmu",
        }
    }

    /// Standard deviation of the position fix with which the paper's column is compared, m.
    pub(crate) fn paper_fix(self) -> Fix {
        match self {
            Filter::Dynamic => Fix::Fine,
            Filter::Kinematic => Fix::Coarse,
        }
    }
}

/// Accuracy of the position fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fix {
    /// 1.5 m per axis.
    Fine,
    /// 2.5 m per axis.
    Coarse,
}

impl Fix {
    /// Both.
    pub(crate) const ALL: [Fix; 2] = [Fix::Fine, Fix::Coarse];

    /// Standard deviation per axis, m.
    pub(crate) fn sigma(self) -> f64 {
        match self {
            Fix::Fine => 1.5,
            Fix::Coarse => 2.5,
        }
    }
}

/// One run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Case {
    pub(crate) course: Course,
    pub(crate) filter: Filter,
    pub(crate) fix: Fix,
    pub(crate) seed: u32,
}

impl Case {
    /// Every combination, seed by seed.
    pub(crate) fn all(seeds: u32) -> Vec<Case> {
        let mut cases = Vec::new();
        for course in Course::ALL {
            for filter in Filter::ALL {
                for fix in Fix::ALL {
                    cases.extend((1..=seeds).map(|seed| Case { course, filter, fix, seed }));
                }
            }
        }
        cases
    }

    /// Whether the run belongs to a column of the paper's tables.
    pub(crate) fn is_in_paper(&self) -> bool {
        self.fix == self.filter.paper_fix()
    }

    /// Name of the result file.
    pub(crate) fn file_name(&self) -> String {
        format!("{}-{}-{}.csv", self.course.name(), self.filter.name(), self.seed)
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (course, filter) = (self.course.name(), self.filter.name());
        write!(f, "{course}, {filter} filter, fix {} m, seed {}", self.fix.sigma(), self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_course_has_both_filters_at_both_fixes_with_paired_seeds() {
        let cases = Case::all(3);
        assert_eq!(cases.len(), 3 * 2 * 2 * 3);
        assert_eq!(cases.iter().filter(|c| c.is_in_paper()).count(), 3 * 2 * 3);
        for case in &cases {
            let other = cases.iter().find(|c| {
                c.filter != case.filter
                    && (c.course, c.fix, c.seed) == (case.course, case.fix, case.seed)
            });
            assert!(other.is_some(), "{case}");
        }
    }

    #[test]
    fn files_of_the_paper_s_runs_have_their_own_names() {
        let mut names: Vec<String> =
            Case::all(4).iter().filter(|c| c.is_in_paper()).map(Case::file_name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 24);
    }
}
