//! Statements: a keyword, what follows it on the line, and perhaps a block in braces.

use super::lexer::{Token, tokens};
use super::{Messages, Span, Value};

/// How deep blocks may be nested.
const MAX_DEPTH: usize = 16;

/// A name with its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Word {
    pub(crate) text: String,
    pub(crate) span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Statement {
    pub(crate) keyword: Word,
    pub(crate) args: Vec<(Span, Value)>,
    pub(crate) block: Option<Vec<Statement>>,
}

/// Reads a text into statements. What cannot be read is reported and left out.
pub(crate) fn parse(file: u16, text: &str, messages: &mut Messages) -> Vec<Statement> {
    let tokens = tokens(file, text, messages);
    let mut parser = Parser {
        tokens,
        at: 0,
        messages,
    };
    parser.statements(None, 0)
}

struct Parser<'a> {
    tokens: Vec<(Span, Token)>,
    at: usize,
    messages: &'a mut Messages,
}

impl Parser<'_> {
    fn next(&mut self) -> Option<(Span, Token)> {
        let token = self.tokens.get(self.at).cloned();
        self.at += 1;
        token
    }

    /// Statements up to the brace that closes the block opened at `opened`, or to the end.
    fn statements(&mut self, opened: Option<Span>, depth: usize) -> Vec<Statement> {
        let mut out: Vec<Statement> = Vec::new();
        while let Some((span, token)) = self.next() {
            match token {
                Token::End => {}
                Token::Close if opened.is_some() => return out,
                Token::Close => self.messages.error(span, "`}` without `{`", "remove it"),
                Token::Open => {
                    let help = "write the keyword and the name before the brace, on the same line";
                    self.messages.error(span, "a block that belongs to nothing", help);
                    if depth < MAX_DEPTH {
                        self.statements(Some(span), depth + 1);
                    }
                }
                Token::Value(Value::Word(text)) => {
                    let statement = self.statement(Word { text, span }, depth);
                    out.push(statement);
                }
                Token::Value(_) => {
                    let help = "every line starts with a keyword; a list of points must stay on its line";
                    self.messages
                        .error(span, "a statement cannot start with this", help);
                    while !matches!(
                        self.tokens.get(self.at),
                        None | Some((_, Token::End | Token::Close))
                    ) {
                        self.at += 1;
                    }
                }
            }
        }
        if let Some(span) = opened {
            self.messages
                .error(span, "this block is never closed", "add the missing `}`");
        }
        out
    }

    fn statement(&mut self, keyword: Word, depth: usize) -> Statement {
        let mut args = Vec::new();
        while let Some((span, token)) = self.tokens.get(self.at).cloned() {
            match token {
                Token::Value(value) => args.push((span, value)),
                Token::Open => {
                    self.at += 1;
                    if depth >= MAX_DEPTH {
                        self.messages
                            .error(span, "blocks are nested too deeply", "use fewer levels");
                        self.at = self.tokens.len();
                        return Statement {
                            keyword,
                            args,
                            block: None,
                        };
                    }
                    let block = Some(self.statements(Some(span), depth + 1));
                    return Statement { keyword, args, block };
                }
                Token::Close | Token::End => break,
            }
            self.at += 1;
        }
        Statement {
            keyword,
            args,
            block: None,
        }
    }
}
