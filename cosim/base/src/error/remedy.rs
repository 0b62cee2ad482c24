//! The remedy for each kind of error, besides what the error itself proposes.

use super::Code;

impl Code {
    /// Where such errors come from, and what helps.
    pub fn remedy(self) -> &'static str {
        match self {
            Code::Usage => "`cosim COMMAND --help` lists the options of a command.",
            Code::File => {
                "Paths in a system description are relative to its folder, those on the command \
                 line to the current one. Check that the file exists and is readable."
            }
            Code::Archive => {
                "Entries are refused if their names leave the folder or collide with others; so \
                 are links, devices, encryption, compression other than deflate, excessive sizes, \
                 and damage. Repack the folder with an ordinary tool, or download the file again."
            }
            Code::Xml => {
                "Parsing stopped at this line: look there and just before it for a tag that \
                 is not closed. A DTD can be removed; FMI, SSP and OSP do not need one."
            }
            Code::Description => {
                "Only the tool that exported the FMU can fix this permanently. Send the line to \
                 its authors; an FMU checker finds more of the same kind."
            }
            Code::Version => {
                "Most tools export for several versions of FMI: choose 2.0. The version of an FMU \
                 is fmiVersion in its modelDescription.xml; `cosim explain E104` helps with \
                 problems in an FMU of FMI 2.0."
            }
            Code::States => {
                "The states of model exchange are defined by <ModelStructure><Derivatives> only \
                 (FMI 2.0.5, 2.2.8). Export the FMU again with a newer version of its tool, or for \
                 co-simulation, or add an <Unknown index=\"...\"/> for each derivative."
            }
            Code::Signature => {
                "Get the file and its signature (FILE.sig) again, and check that the public key \
                 belongs to the author of the file. Do not run a file that does not verify."
            }
            Code::Library => {
                "`cosim info` lists the platforms of an FMU. A library that cannot be loaded \
                 usually lacks another one: `ldd` on the .so file in binaries/ shows which."
            }
            Code::Ssd => {
                "Look up the element at this line in the standard. Elements that are not supported \
                 must be removed, or replaced by supported ones: see the page on formats."
            }
            Code::UnknownName => {
                "Names are case-sensitive. `cosim info` lists the variables \
                 of an FMU and the components of a system."
            }
            Code::Connection => {
                "Connect an output, or a parameter of the same type, to an input, and each input \
                 only once. In SSP, both must be connectors of their components."
            }
            Code::Parameter => {
                "Start values can be set for inputs and parameters, not for outputs, constants and \
                 calculated variables. `cosim info FMU` shows type, limits and causality."
            }
            Code::Timing => {
                "Choose a stop time after the start time, steps that are multiples of a common \
                 base, and an output interval that is a multiple of it. Times are counted in \
                 nanoseconds; a step may be a fraction of them, as 1/30 s is."
            }
            Code::Replacement => {
                "An FMU can replace another one when it has all variables that the system connects \
                 to. Compare `cosim info` of both."
            }
            Code::Scenario => {
                "A scenario is a list of faults in TOML (`cosim explain faults` shows every kind), \
                 or JSON as in OSP: a list `events` of time, model, variable, action and value. \
                 The error names the line or the event."
            }
            Code::Source => {
                "Put the file into the archive, or beside the description, and name it by a \
                 relative path without `..`."
            }
            Code::Unit => {
                "Units of one dimension are converted (deg to rad). For others correct the \
                 declared unit, or specify a linear transformation."
            }
            Code::Format => {
                "Choose the other format, or remove from the system what the error names."
            }
            Code::Campaign => {
                "The page on campaigns shows every part of such a file. Results of another \
                 campaign are not changed: choose another --output-dir."
            }
            Code::Roles => {
                "The page on files for other tools shows such a file. Variables are named as in \
                 the results."
            }
            Code::Missed => {
                "The table names the cells; `cosim replay` repeats one of their runs and records \
                 everything."
            }
            Code::Undecided => {
                "Raise `seeds` in the file by the number in the table and run the command again: \
                 existing runs are kept."
            }
            Code::Fmu => {
                "The FMU's own messages follow the error; `--debug-logging` requests more, and \
                 `--log-fmi-calls` shows each call before it with its values. Often a smaller step \
                 or another start value helps."
            }
            Code::Output => {
                "Check that the disk is not full, and that the folder exists and is writable."
            }
            Code::Interrupted => {
                "Nothing is wrong. With `--snapshot-every` a later run can continue from there \
                 with `--resume`."
            }
            Code::State => {
                "`cosim info` shows whether the FMU declares canGetAndSetFMUstate and \
                 canSerializeFMUstate. If not, run it without snapshots, iteration and step \
                 control."
            }
            Code::Loop => {
                "Use a smaller step, start values closer to the solution, or the algorithm \
                 gauss-seidel, which holds one connection of the loop for a step. `cosim inspect` \
                 names its members."
            }
            Code::Step => {
                "Check what happens at that time: a discontinuity cannot be stepped over with any \
                 tolerance. Use a larger tolerance, or more `--retries`."
            }
            Code::Snapshot => {
                "A snapshot must be resumed with the same files, start values, steps, algorithm \
                 and recorded variables with which it was taken, and the same version of cosim."
            }
            Code::Ended => "Nothing is wrong, unless you expected the FMU to continue.",
            Code::Protocol => {
                "Use the same version of cosim on all machines; if you do, this is a bug in cosim."
            }
            Code::Lost => {
                "Check the messages of that worker. With more workers (`--min-workers`) and saved \
                 states another one can take over."
            }
            Code::Placement => "`cosim workers` lists the connected workers and what each can run.",
            Code::Session => {
                "Check that both sides use the same endpoint, that its port is open, and that \
                 certificate and rights match this run."
            }
            Code::Differs => {
                "Look for random numbers without a seed, use of the clock, and uninitialized \
                 memory in the FMU; or for data that is missing in its saved state."
            }
            Code::Certificate => {
                "`cosim keys` makes an authority and a certificate for each machine; all sides \
                 need those of the same authority. The error names the file or the name that is \
                 wrong."
            }
            Code::Forbidden => {
                "Use the certificate that was made for this role: a worker speaks under its own \
                 name only, and an observer may only read telemetry."
            }
            Code::NotAllowed => {
                "Start the worker with `--allow` and the hash, file or folder, or with \
                 `--allow-upload` if you trust everything that this coordinator sends."
            }
            Code::Configuration => {
                "The file is Zenoh's configuration with an object `cosim` of our own keys; the \
                 error names the key."
            }
            Code::Parted => {
                "Check that both runs had the same FMUs, start values and versions; `cosim verify` \
                 shows when they diverge, and `--log-fmi-calls` the calls before that."
            }
            Code::Results => {
                "`cosim run` writes MCAP and CSV; other CSV files need the time in the first column."
            }
            Code::Report => "The error names the file or variable that a figure could not use.",
        }
    }
}
