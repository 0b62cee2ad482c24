//! The kinds of error, their stable codes, exit codes and explanations.

use std::fmt;

macro_rules! codes {
    ($($name:ident $text:literal $exit:literal $explanation:literal)*) => {
        /// A kind of error with a stable code such as `E203`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Code {
            $(#[doc = $explanation] $name,)*
        }

        impl Code {
            /// All codes, in numerical order.
            pub const ALL: &[Code] = &[$(Code::$name),*];

            /// The stable text, for example `E203`.
            pub fn as_str(self) -> &'static str {
                match self { $(Code::$name => $text),* }
            }

            /// The exit code of the command line: 1 run failed, 2 usage, 3 not valid, 4
            /// undecided, 130 interrupted.
            pub fn exit_code(self) -> u8 {
                match self { $(Code::$name => $exit),* }
            }

            /// What the code means.
            pub fn explanation(self) -> &'static str {
                match self { $(Code::$name => $explanation),* }
            }
        }
    };
}

codes! {
    Usage "E001" 2 "The command line cannot be understood, or two of its options contradict each other."
    File "E101" 3 "A file that the run needs is missing or cannot be read."
    Archive "E102" 3 "An .fmu or .ssp file is not a ZIP archive that can be unpacked safely."
    Xml "E103" 3 "An XML file is not well-formed, or contains a DTD, entities or very deep nesting, which are refused."
    Description "E104" 3 "A modelDescription.xml breaks FMI 2.0."
    Library "E105" 3 "The shared library of an FMU is missing, cannot be loaded or lacks an FMI function."
    Version "E106" 3 "The FMI version of an FMU is not 2.0."
    States "E107" 3 "An FMU for model exchange has derivatives, but does not list them: no state would be integrated."
    Signature "E108" 3 "A file that must be signed has no signature, or one by another key or for other content."
    Ssd "E201" 3 "A system description breaks its format (SSP or OSP), or uses a part of it that is not supported."
    UnknownName "E202" 3 "A component or variable that was named does not exist."
    Connection "E203" 3 "A connection is not possible: causality, type, or two sources for one input."
    Parameter "E204" 3 "A start value cannot be given to that variable, or its text is not a value of the variable's type; or a variable that must be a number is a String."
    Timing "E205" 3 "Step sizes, start, stop or output interval do not fit together."
    Replacement "E206" 3 "The FMU put in place of another lacks an output that other components need."
    Scenario "E207" 3 "A scenario file cannot be understood."
    Source "E208" 3 "A path in a system description is refused: it leads out of the archive of the description, or is not a valid path on this machine."
    Unit "E209" 3 "A connection or a value combines units of different dimensions."
    Format "E210" 3 "The target format of a system cannot express a part of it."
    Campaign "E211" 3 "The file of a campaign cannot be understood, or the existing results belong to another campaign."
    Roles "E212" 3 "A file that assigns roles to variables (--roles) cannot be understood."
    Fmu "E301" 1 "A function of an FMU returned an error while the system ran."
    Output "E302" 1 "Results could not be written."
    Interrupted "E303" 130 "The user interrupted the run (ctrl-C); the results until then are kept."
    State "E304" 1 "The state of an FMU could not be saved, restored or serialized."
    Loop "E305" 1 "The iteration that solves an algebraic loop did not converge."
    Step "E306" 1 "No communication step was small enough: for the tolerance, or for an FMU that discards steps."
    Snapshot "E307" 3 "A snapshot cannot be read, is damaged, or belongs to another system."
    Ended "E308" 1 "An FMU ended the run itself. In a run this is not an error: the run ends there, and its results are kept."
    Results "E401" 3 "A file of recorded results cannot be read."
    Report "E402" 1 "A report could not be made."
    Parted "E403" 1 "Two recordings that were compared are not the same."
    Missed "E404" 1 "A threshold of a campaign is not met, with the requested confidence."
    Undecided "E405" 4 "The runs of a campaign leave a threshold undecided: more seeds are needed."
    Protocol "E501" 1 "The coordinator and a worker did not understand each other, or a message arrived out of order."
    Lost "E502" 1 "A worker, or the process with its components, ended or stopped responding, and no other could take over."
    Placement "E503" 2 "A component cannot run where it was placed, or the run cannot be distributed in this way."
    Session "E504" 1 "A Zenoh session could not be opened: an endpoint, a certificate or a right is missing or wrong."
    Differs "E505" 1 "A repeated computation gave different values: an FMU is not deterministic, or its saved state is incomplete."
    Certificate "E506" 1 "A certificate, its key or its authority is missing, not valid now, or not trusted by the other side."
    Forbidden "E507" 1 "The other side does not grant this right to the name in the certificate."
    NotAllowed "E508" 1 "A worker was asked to load an FMU that is not allowed there."
    Configuration "E509" 3 "A configuration file cannot be understood, or requests something that is not permitted."
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_stand_in_the_order_of_their_numbers() {
        assert!(Code::ALL.is_sorted_by_key(|code| code.as_str()));
    }
}
