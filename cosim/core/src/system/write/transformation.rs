//! Conversions of connections in the form of SSP.

use fmu_standard::{Xml, number};

use crate::system::Conversion;
use cosim_base::units::Linear;
use cosim_import::Kind;

/// Writes a conversion as a transformation.
pub(super) fn write(xml: &mut Xml, conversion: &Conversion, kind: &Kind) {
    let entries = match conversion {
        Conversion::Linear(Linear { factor, offset }) => {
            let (factor, offset) = (number(*factor), number(*offset));
            let attributes = [("factor", factor.as_str()), ("offset", offset.as_str())];
            return xml.empty("ssc:LinearTransformation", &attributes);
        }
        Conversion::Map(entries) => entries,
    };
    let boolean = *kind == Kind::Boolean;
    xml.start(
        if boolean {
            "ssc:BooleanMappingTransformation"
        } else {
            "ssc:IntegerMappingTransformation"
        },
        &[],
    );
    for (source, target) in entries {
        let text = |value: i32| match boolean {
            true => (value != 0).to_string(),
            false => value.to_string(),
        };
        let (source, target) = (text(*source), text(*target));
        xml.empty("ssc:MapEntry", &[("source", &source), ("target", &target)]);
    }
    xml.close();
}
