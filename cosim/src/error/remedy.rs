//! What to do about each kind of error, beside what the error itself proposes.

use super::Code;

impl Code {
    /// Where such errors come from, and what helps.
    pub fn remedy(self) -> &'static str {
        match self {
            Code::Usage => "`cosim COMMAND --help` lists the options of a command.",
            Code::File => {
                "Paths in a system description are relative to its folder, those on the command \
                 line to the present one. See that the file exists and may be read."
            }
            Code::Archive => {
                "Refused are entries whose names leave the folder or meet another one, links, \
                 devices, encryption, other compressions than deflate, absurd sizes, and damage. \
                 Pack the folder again with an ordinary tool, or download the file again."
            }
            Code::Xml => {
                "The line is where reading stopped: look there and just before it for a tag that \
                 is not closed. A DTD can be removed, FMI, SSP and OSP need none."
            }
            Code::Description => {
                "Only the tool that exported the FMU can mend this for good. Send its authors the \
                 line; a checker of FMUs tells more of the same kind."
            }
            Code::Version => {
                "Most tools export for several versions of FMI: choose 2.0. What an FMU is of says \
                 fmiVersion in its modelDescription.xml, and `cosim explain E104` what is wrong in \
                 one of FMI 2.0."
            }
            Code::States => {
                "The states of model exchange are found by <ModelStructure><Derivatives> alone \
                 (FMI 2.0.5, 2.2.8). Export the FMU again with a newer version of its tool, or for \
                 co-simulation, or add an <Unknown index=\"...\"/> for each derivative."
            }
            Code::Signature => {
                "Get file and signature (FILE.sig) once more, and see that the public key is that \
                 of whoever made the file. Do not run what does not verify."
            }
            Code::Library => {
                "`cosim info` lists the platforms of an FMU. A library that cannot be loaded \
                 mostly misses another one: `ldd` on the .so file in binaries/ shows which."
            }
            Code::Ssd => {
                "Look up the element at this line in the standard. What is not supported must be \
                 removed, or expressed by what is: see the page on formats."
            }
            Code::UnknownName => {
                "Names are compared letter by letter, with case. `cosim info` lists the variables \
                 of an FMU and the components of a system."
            }
            Code::Connection => {
                "Connect one output, or parameter of the same type, to an input, and each input \
                 once. Of SSP, both must be connectors of their components."
            }
            Code::Parameter => {
                "Start values can be given to inputs and parameters, not to outputs, constants and \
                 what the FMU calculates. `cosim info FMU` shows type, limits and causality."
            }
            Code::Timing => {
                "Choose a stop after the start, steps that are multiples of a common base, and an \
                 output interval that is a multiple of it. Times are counted in nanoseconds; a step \
                 may be a fraction of them, as 1/30 s is."
            }
            Code::Replacement => {
                "An FMU can replace another one when it has all variables that the system connects \
                 to. `cosim info` of both shows where they differ."
            }
            Code::Scenario => {
                "A scenario is a list of faults in TOML (`cosim explain faults` shows every kind), or \
                 JSON as in OSP: a list `events` of time, model, variable, action and value. The error \
                 names the line or the event."
            }
            Code::Source => {
                "Put the file into the archive, or beside the description, and name it by a \
                 relative path without `..`."
            }
            Code::Unit => {
                "Units of one dimension are converted (deg to rad). For others correct the \
                 declared unit, or say what is meant by a linear transformation."
            }
            Code::Format => {
                "Choose the other format, or take out of the system what the error names."
            }
            Code::Campaign => {
                "The page on campaigns shows every part of such a file. Results of another campaign \
                 stay as they are: give --output-dir another folder."
            }
            Code::Roles => {
                "The page on files for other tools shows such a file. Variables are named as in the \
                 results."
            }
            Code::Missed => {
                "The table names the cells; `cosim replay` makes one of their runs again and records \
                 all of it."
            }
            Code::Undecided => {
                "Raise `seeds` in the file by what the table says and give the command again: runs \
                 that are there are kept."
            }
            Code::Fmu => {
                "The FMU's own messages follow the error; `--debug-logging` asks it for more, and \
                 `--log-fmi-calls` shows each call before it with its values. Often a smaller step \
                 or another start value helps."
            }
            Code::Output => "Is the disk full, the folder there, and may you write there?",
            Code::Interrupted => {
                "Nothing is wrong. With `--snapshot-every` a later run can go on from there by \
                 `--resume`."
            }
            Code::State => {
                "`cosim info` shows whether the FMU declares canGetAndSetFMUstate and \
                 canSerializeFMUstate. Do without snapshots, iteration and step control for it."
            }
            Code::Loop => {
                "Take a smaller step, start values nearer to the solution, or the algorithm \
                 gauss-seidel, which holds one connection of the loop for a step. `cosim inspect` \
                 names its members."
            }
            Code::Step => {
                "Look at what happens at that time: a jump cannot be stepped over with any \
                 tolerance. Allow a greater tolerance, or more `--retries`."
            }
            Code::Snapshot => {
                "A snapshot is resumed with the same files, start values, steps, algorithm and \
                 recorded variables as it was taken with, and the same version of cosim."
            }
            Code::Ended => "Nothing is wrong, unless you expected the FMU to go on.",
            Code::Protocol => {
                "Use one version of cosim on all machines; if it is one, this is an error of ours."
            }
            Code::Lost => {
                "See the messages of that worker. With more workers (`--min-workers`) and saved \
                 states another one can take over."
            }
            Code::Placement => "`cosim workers` lists who is there and what each can run.",
            Code::Session => {
                "See that both sides name the same endpoint, that its port is open, and that \
                 certificate and rights are those of this run."
            }
            Code::Differs => {
                "Look for random numbers without a seed, the clock, and uninitialized memory in \
                 the FMU; or for something that it forgets in its saved state."
            }
            Code::Certificate => {
                "`cosim keys` makes an authority and a certificate for each machine; all sides need \
                 those of the same authority. The error names the file or the name that is wrong."
            }
            Code::Forbidden => {
                "Use the certificate that was made for this role: a worker speaks under its own \
                 name only, an observer may listen to telemetry and nothing else."
            }
            Code::NotAllowed => {
                "Start the worker with `--allow` and the hash, file or folder, or with \
                 `--allow-upload` if you trust all that this coordinator sends."
            }
            Code::Configuration => {
                "The file is Zenoh's configuration with an object `cosim` of our own keys; the \
                 error names the key."
            }
            Code::Parted => {
                "See whether both runs had the same FMUs, start values and versions; `cosim verify` \
                 tells when they part, and `--log-fmi-calls` what was said before."
            }
            Code::Results => {
                "`cosim run` writes MCAP and CSV; CSV of others needs the time in its first column."
            }
            Code::Report => "The error names the file or the variable that a figure could not use.",
        }
    }
}
