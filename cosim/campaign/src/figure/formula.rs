//! Formulas over named variables, such as `sqrt({a.x}^2 + {a.y}^2)`.
//!
//! `^` binds more strongly than a sign, and from the right: `-x^2^3` is `-(x^(2^3))`.

use std::f64::consts::{E, PI, TAU};
use std::iter::Peekable;
use std::str::CharIndices;

use cosim_base::names::did_you_mean;

/// A formula as operations on a stack.
#[derive(Debug, Clone)]
pub(super) struct Formula {
    steps: Vec<Step>,
    /// Its variables, in the order in which they first occur.
    pub(super) variables: Vec<String>,
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Number(f64),
    Variable(usize),
    One(One),
    Two(Two),
}

type One = fn(f64) -> f64;
type Two = fn(f64, f64) -> f64;

const CONSTANTS: [(&str, f64); 4] = [("PI", PI), ("π", PI), ("E", E), ("TAU", TAU)];

static FUNCTIONS: [(&str, One); 23] = [
    ("abs", libm::fabs),
    ("acos", libm::acos),
    ("asin", libm::asin),
    ("atan", libm::atan),
    ("cbrt", libm::cbrt),
    ("ceil", libm::ceil),
    ("cos", libm::cos),
    ("cosh", libm::cosh),
    ("exp", libm::exp),
    ("floor", libm::floor),
    ("fract", |x| x - libm::trunc(x)),
    ("ln", libm::log),
    ("log", libm::log),
    ("log10", libm::log10),
    ("log2", libm::log2),
    ("round", libm::round),
    ("signum", f64::signum),
    ("sin", libm::sin),
    ("sinh", libm::sinh),
    ("sqrt", libm::sqrt),
    ("tan", libm::tan),
    ("tanh", libm::tanh),
    ("trunc", libm::trunc),
];

static FUNCTIONS_OF_TWO: [(&str, Two); 3] =
    [("atan2", libm::atan2), ("max", f64::max), ("min", f64::min)];

/// Binary operators, and how strongly each binds what stands before and after it.
static OPERATORS: [(char, Two, [u8; 2]); 5] = [
    ('+', |a, b| a + b, [1, 2]),
    ('-', |a, b| a - b, [1, 2]),
    ('*', |a, b| a * b, [3, 4]),
    ('/', |a, b| a / b, [3, 4]),
    ('^', libm::pow, [7, 6]),
];
/// How strongly a sign binds.
const SIGN: u8 = 5;

/// The longest formula, in bytes.
const LONGEST: usize = 10_000;
/// The most levels of parentheses, signs and powers.
const DEEPEST: usize = 64;

impl Formula {
    /// Fails with what is wrong, and where.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("it has more than {LONGEST} bytes"));
        }
        let empty = Self { steps: Vec::new(), variables: Vec::new() };
        let mut reader = Reader { text, rest: text.char_indices().peekable(), formula: empty };
        reader.operand(0, 0)?;
        match reader.next() {
            None => Ok(reader.formula),
            Some(_) => reader.unexpected("an operator"),
        }
    }

    /// Its value for values of its variables.
    pub(super) fn value(&self, variables: &[f64], stack: &mut Vec<f64>) -> f64 {
        stack.clear();
        for step in &self.steps {
            let mut pop = || stack.pop().unwrap_or(f64::NAN);
            let value = match *step {
                Step::Number(number) => number,
                Step::Variable(place) => variables[place],
                Step::One(function) => function(pop()),
                Step::Two(function) => {
                    let second = pop();
                    function(pop(), second)
                }
            };
            stack.push(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}

struct Reader<'t> {
    text: &'t str,
    rest: Peekable<CharIndices<'t>>,
    formula: Formula,
}

impl<'t> Reader<'t> {
    /// Reads an operand, with all that follows and binds more strongly than `binding`.
    fn operand(&mut self, binding: u8, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("it has more than {DEEPEST} levels of parentheses"));
        }
        match self.next() {
            Some('-') => {
                self.skip();
                self.operand(SIGN, depth + 1)?;
                self.formula.steps.push(Step::One(|x| -x));
            }
            Some('+') => {
                self.skip();
                self.operand(SIGN, depth + 1)?;
            }
            Some('(') => {
                self.skip();
                self.operand(0, depth + 1)?;
                self.expect(')')?;
            }
            Some('{') => self.variable()?,
            Some(digit) if digit.is_ascii_digit() || digit == '.' => self.number()?,
            Some(letter) if letter.is_alphabetic() => self.name(depth)?,
            _ => return self.unexpected("a number, a name in braces or a function"),
        }
        while let Some(next) = self.next()
            && let Some((_, function, [before, after])) =
                OPERATORS.iter().find(|(sign, ..)| *sign == next)
            && *before > binding
        {
            self.skip();
            self.operand(*after, depth + 1)?;
            self.formula.steps.push(Step::Two(*function));
        }
        Ok(())
    }

    fn variable(&mut self) -> Result<(), String> {
        let begin = self.place() + 1;
        let Some(length) = self.text[begin..].find('}') else {
            return Err(format!("the brace at character {} is not closed", self.character()));
        };
        let name = &self.text[begin..begin + length];
        self.take_while(|place, _| place <= begin + length);
        let variables = &mut self.formula.variables;
        let place = variables.iter().position(|known| known == name).unwrap_or_else(|| {
            variables.push(name.to_owned());
            variables.len() - 1
        });
        self.formula.steps.push(Step::Variable(place));
        Ok(())
    }

    fn number(&mut self) -> Result<(), String> {
        let (at, mut last) = (self.character(), ' ');
        let text = self.take_while(|_, next| {
            let exponent = last.is_ascii_digit() || last == '.';
            let belongs = match next {
                '0'..='9' | '.' => true,
                'e' | 'E' => exponent,
                '+' | '-' => matches!(last, 'e' | 'E'),
                _ => false,
            };
            last = next;
            belongs
        });
        let number =
            text.parse().map_err(|_| format!("'{text}' at character {at} is no number"))?;
        self.formula.steps.push(Step::Number(number));
        Ok(())
    }

    /// A function with its arguments, or a constant.
    fn name(&mut self, depth: usize) -> Result<(), String> {
        let at = self.character();
        let name = self.take_while(|_, next| next.is_alphanumeric() || next == '_');
        if let Some((_, number)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            self.formula.steps.push(Step::Number(*number));
            return Ok(());
        }
        let one = FUNCTIONS.iter().find(|(known, _)| *known == name);
        let two = FUNCTIONS_OF_TWO.iter().find(|(known, _)| *known == name);
        if one.is_none() && two.is_none() {
            let functions = FUNCTIONS.iter().map(|(name, _)| *name);
            let known = functions.chain(FUNCTIONS_OF_TWO.iter().map(|(name, _)| *name));
            let help = did_you_mean(name, known.chain(CONSTANTS.iter().map(|(name, _)| *name)));
            let help = help.unwrap_or("names of variables stand in braces".to_owned());
            return Err(format!("'{name}' at character {at} is not a function: {help}"));
        }
        self.expect('(')?;
        self.operand(0, depth + 1)?;
        if let Some((_, function)) = one {
            self.formula.steps.push(Step::One(*function));
        }
        if let Some((_, function)) = two {
            self.expect(',')?;
            self.operand(0, depth + 1)?;
            self.formula.steps.push(Step::Two(*function));
        }
        self.expect(')')
    }

    /// The next character that is not a space.
    fn next(&mut self) -> Option<char> {
        while self.rest.next_if(|(_, next)| next.is_whitespace()).is_some() {}
        self.rest.peek().map(|(_, next)| *next)
    }

    fn skip(&mut self) {
        self.rest.next();
    }

    fn take_while(&mut self, mut belongs: impl FnMut(usize, char) -> bool) -> &'t str {
        let begin = self.place();
        while self.rest.next_if(|(place, next)| belongs(*place, *next)).is_some() {}
        let end = self.place();
        &self.text[begin..end]
    }

    fn expect(&mut self, wanted: char) -> Result<(), String> {
        match self.next() {
            Some(next) if next == wanted => {
                self.skip();
                Ok(())
            }
            _ => self.unexpected(&format!("'{wanted}'")),
        }
    }

    fn unexpected<T>(&mut self, wanted: &str) -> Result<T, String> {
        Err(match self.next() {
            Some(next) => {
                format!("'{next}' at character {} stands where {wanted} should", self.character())
            }
            None => format!("it ends where {wanted} should stand"),
        })
    }

    /// Where the next character begins, in bytes.
    fn place(&mut self) -> usize {
        self.rest.peek().map_or(self.text.len(), |(place, _)| *place)
    }

    /// The number of the next character, from one.
    fn character(&mut self) -> usize {
        let place = self.place();
        self.text[..place].chars().count() + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let formula = Formula::read(text).unwrap_or_else(|why| panic!("{text}: {why}"));
        formula.value(&[3.0, -4.0, 0.5], &mut Vec::new())
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        let cases = [
            ("{x} - {y} - 1", 6.0),
            ("{x} + {y} * 2", -5.0),
            ("({x} + {y}) * 2", -2.0),
            ("12 / 3 / 2", 2.0),
            ("2^3^2", 512.0),
            ("-{x}^2", -9.0),
            ("2^-1", 0.5),
            ("-2 * -{x}", 6.0),
            ("2^-2^2", 0.0625),
            ("--{x}", 3.0),
            ("6 - +{x}", 3.0),
            ("1.5e1 + .5 + 1E-1 * 10", 16.5),
            ("2e+1", 20.0),
            ("{x}*{x}", 9.0),
        ];
        for (text, wanted) in cases {
            assert_eq!(value(text), wanted, "{text}");
        }
    }

    #[test]
    fn functions_and_constants_have_their_values() {
        let cases = [
            ("sqrt({x}^2 + {y}^2)", 5.0),
            ("max(abs({x}), {y}) + min({x}, -1)", 2.0),
            ("atan2({x}, 0) - PI / 2", 0.0),
            ("E - exp(1)", 0.0),
            ("log(exp(2)) + log10(100) + log2(8) + cbrt(27)", 10.0),
            ("fract(-2.25) + trunc(-2.5) + round(2.5) + floor(-0.5) + ceil(0.5)", 0.75),
            ("sin(TAU / 4)", 1.0),
            ("signum({x}) * π", PI),
        ];
        for (text, wanted) in cases {
            assert!((value(text) - wanted).abs() < 1e-15, "{text}: {}", value(text));
        }
    }

    #[test]
    fn variables_have_one_place_each() {
        let formula = Formula::read("{b[1].y} + {a x} * {b[1].y}").unwrap();
        assert_eq!(formula.variables, ["b[1].y", "a x"]);
        assert_eq!(formula.value(&[2.0, 5.0], &mut Vec::new()), 12.0);
    }

    #[test]
    fn what_is_no_formula_is_told_with_its_place() {
        let cases = [
            ("{x} +* 2", "'*' at character 6 stands where a number"),
            ("{x} 2", "'2' at character 5 stands where an operator should"),
            ("{x", "the brace at character 1 is not closed"),
            ("(1 + 2", "it ends where ')' should stand"),
            ("", "it ends where a number"),
            ("1..2", "'1..2' at character 1 is no number"),
            ("sqr({x})", "'sqr' at character 1 is not a function: did you mean 'sqrt'?"),
            ("2 * speed_of_sound", "'speed_of_sound' at character 5 is not a function: names of"),
            ("max({x})", "')' at character 8 stands where ',' should"),
            ("abs {x}", "'{' at character 5 stands where '(' should"),
            ("ä", "'ä' at character 1"),
        ];
        for (text, wanted) in cases {
            let why = Formula::read(text).unwrap_err();
            assert!(why.starts_with(wanted), "{text}: {why}");
        }
        for deep in ["(".repeat(100), "-".repeat(9_000), "2^".repeat(4_000), "9".repeat(20_000)] {
            assert!(Formula::read(&deep).unwrap_err().starts_with("it has more than"));
        }
    }
}
