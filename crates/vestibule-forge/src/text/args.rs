//! Reading what follows a keyword.

use glam::{DVec2, DVec3};

use super::{Above, Messages, Span, Statement, Value, Word};

/// The statement cannot be used; the message has been written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skip;

/// The arguments of a statement, read from left to right.
pub(crate) struct Args<'a> {
    statement: &'a Statement,
    at: usize,
    /// How the statement is written, for messages.
    usage: &'static str,
}

impl<'a> Args<'a> {
    pub(crate) fn new(statement: &'a Statement, usage: &'static str) -> Self {
        Args {
            statement,
            at: 0,
            usage,
        }
    }

    pub(crate) fn keyword_span(&self) -> Span {
        self.statement.keyword.span
    }

    /// Where the next argument is, or the keyword if there is none.
    pub(crate) fn span(&self) -> Span {
        self.statement
            .args
            .get(self.at)
            .map_or(self.statement.keyword.span, |(span, _)| *span)
    }

    fn peek(&self) -> Option<&'a Value> {
        self.statement.args.get(self.at).map(|(_, value)| value)
    }

    fn wrong(&self, wanted: &str, messages: &mut Messages) -> Skip {
        let keyword = &self.statement.keyword.text;
        let found = match self.peek() {
            None => "nothing".to_owned(),
            Some(Value::Word(word)) => format!("`{word}`"),
            Some(Value::Number(number)) => format!("the number {number}"),
            Some(Value::Text(_)) => "a text".to_owned(),
            Some(Value::Tuple(numbers)) => format!("a point of {} numbers", numbers.len()),
        };
        let message = format!("`{keyword}` needs {wanted} here, found {found}");
        messages.error(self.span(), message, format!("write: {}", self.usage));
        Skip
    }

    pub(crate) fn more(&self) -> bool {
        self.at < self.statement.args.len()
    }

    pub(crate) fn word(&mut self, what: &str, messages: &mut Messages) -> Result<Word, Skip> {
        self.any_word().ok_or_else(|| self.wrong(what, messages))
    }

    /// Takes the next word if it is `word`.
    pub(crate) fn accept(&mut self, word: &str) -> bool {
        let found = matches!(self.peek(), Some(Value::Word(text)) if text == word);
        self.at += usize::from(found);
        found
    }

    /// Takes the next word, if there is one.
    pub(crate) fn any_word(&mut self) -> Option<Word> {
        match self.peek() {
            Some(Value::Word(text)) => {
                let word = Word {
                    text: text.clone(),
                    span: self.span(),
                };
                self.at += 1;
                Some(word)
            }
            _ => None,
        }
    }

    pub(crate) fn text(&mut self, what: &str, messages: &mut Messages) -> Result<String, Skip> {
        match self.peek() {
            Some(Value::Text(text) | Value::Word(text)) => {
                self.at += 1;
                Ok(text.clone())
            }
            _ => Err(self.wrong(what, messages)),
        }
    }

    pub(crate) fn number(&mut self, what: &str, messages: &mut Messages) -> Result<f64, Skip> {
        match self.peek() {
            Some(Value::Number(number)) => {
                self.at += 1;
                Ok(*number)
            }
            _ => Err(self.wrong(what, messages)),
        }
    }

    pub(crate) fn any_number(&mut self) -> Option<f64> {
        match self.peek() {
            Some(Value::Number(number)) => {
                self.at += 1;
                Some(*number)
            }
            _ => None,
        }
    }

    /// A landblock or cell number, written 0xA9B4.
    pub(crate) fn hex(&mut self, what: &str, messages: &mut Messages) -> Result<u16, Skip> {
        let value = match self.peek() {
            Some(Value::Word(text)) => text
                .strip_prefix("0x")
                .and_then(|digits| u16::from_str_radix(digits, 16).ok()),
            _ => None,
        };
        match value {
            Some(value) => {
                self.at += 1;
                Ok(value)
            }
            None => Err(self.wrong(what, messages)),
        }
    }

    fn tuple(&mut self, length: usize) -> Option<&'a [Above]> {
        match self.peek() {
            Some(Value::Tuple(numbers)) if numbers.len() == length => {
                self.at += 1;
                Some(numbers)
            }
            _ => None,
        }
    }

    pub(crate) fn point2(&mut self, messages: &mut Messages) -> Result<DVec2, Skip> {
        match self.tuple(2) {
            Some(n) => Ok(DVec2::new(n[0].metres, n[1].metres)),
            None => Err(self.wrong("a point (x y)", messages)),
        }
    }

    pub(crate) fn point3(&mut self, messages: &mut Messages) -> Result<DVec3, Skip> {
        match self.tuple(3) {
            Some(n) if n.iter().all(|n| !n.ground) => Ok(DVec3::new(n[0].metres, n[1].metres, n[2].metres)),
            found => {
                // Point at the offending point itself.
                self.at -= usize::from(found.is_some());
                Err(self.wrong("a point (x y z)", messages))
            }
        }
    }

    /// A point whose height may be written as ~z: metres above the ground.
    pub(crate) fn place(&mut self, messages: &mut Messages) -> Result<(DVec2, Above), Skip> {
        match self.tuple(3) {
            Some(n) => Ok((DVec2::new(n[0].metres, n[1].metres), n[2])),
            None => Err(self.wrong(
                "a place (x y z), or (x y ~z) for a height above the ground,",
                messages,
            )),
        }
    }

    pub(crate) fn points2(&mut self, least: usize, messages: &mut Messages) -> Result<Vec<DVec2>, Skip> {
        let mut out = Vec::new();
        while out.len() < least || matches!(self.peek(), Some(Value::Tuple(_))) {
            out.push(self.point2(messages)?);
        }
        Ok(out)
    }

    pub(crate) fn points3(&mut self, least: usize, messages: &mut Messages) -> Result<Vec<DVec3>, Skip> {
        let mut out = Vec::new();
        while out.len() < least || matches!(self.peek(), Some(Value::Tuple(_))) {
            out.push(self.point3(messages)?);
        }
        Ok(out)
    }

    /// Complains about what is left over.
    pub(crate) fn end(&self, messages: &mut Messages) -> Result<(), Skip> {
        if self.more() {
            Err(self.wrong("nothing more", messages))
        } else {
            Ok(())
        }
    }
}
