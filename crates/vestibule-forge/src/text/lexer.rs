//! Words, numbers, points and braces.

use super::Messages;

/// A place in the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Span {
    pub(crate) file: u16,
    pub(crate) line: u32,
    pub(crate) column: u32,
}

/// A height: metres, or metres above the ground (`~`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Above {
    pub(crate) metres: f64,
    pub(crate) ground: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Word(String),
    Number(f64),
    Text(String),
    /// `(x y z)`; the numbers written with `~` are marked.
    Tuple(Vec<Above>),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    Value(Value),
    Open,
    Close,
    /// End of a statement: a line's end, or `;`.
    End,
}

/// Cuts a text into tokens. `#` starts a comment.
pub(crate) fn tokens(file: u16, text: &str, messages: &mut Messages) -> Vec<(Span, Token)> {
    let mut out = Vec::new();
    let mut tuple: Option<(Span, Vec<Above>)> = None;
    for (number, line) in (1u32..).zip(text.lines()) {
        let mut rest = line.char_indices().zip(1u32..).peekable();
        while let Some(&((at, c), column)) = rest.peek() {
            let span = Span {
                file,
                line: number,
                column,
            };
            match c {
                '#' => break,
                '"' => {
                    rest.next();
                    let text: String = rest
                        .by_ref()
                        .map(|((_, c), _)| c)
                        .take_while(|c| *c != '"')
                        .collect();
                    out.push((span, Token::Value(Value::Text(text))));
                }
                '(' => {
                    rest.next();
                    if tuple.replace((span, Vec::new())).is_some() {
                        messages.error(span, "a point inside a point", "close the first one with `)`");
                    }
                }
                ')' => {
                    rest.next();
                    match tuple.take() {
                        Some((start, numbers)) => out.push((start, Token::Value(Value::Tuple(numbers)))),
                        None => {
                            messages.error(span, "`)` without `(`", "remove it, or open the point with `(`")
                        }
                    }
                }
                '{' | '}' | ';' => {
                    rest.next();
                    let token = match c {
                        '{' => Token::Open,
                        '}' => Token::Close,
                        _ => Token::End,
                    };
                    out.push((span, token));
                }
                c if c.is_whitespace() || c == ',' => {
                    rest.next();
                }
                _ => {
                    let mut end = at;
                    while let Some(&((k, c), _)) = rest.peek() {
                        if c.is_whitespace() || "#\"(){};,".contains(c) {
                            break;
                        }
                        end = k + c.len_utf8();
                        rest.next();
                    }
                    word(span, &line[at..end], &mut tuple, &mut out, messages);
                }
            }
        }
        // A point may run over several lines; a statement may not.
        if tuple.is_none() {
            out.push((
                Span {
                    file,
                    line: number,
                    column: line.chars().count() as u32 + 1,
                },
                Token::End,
            ));
        }
    }
    if let Some((span, _)) = tuple {
        messages.error(span, "this point is never closed", "add the missing `)`");
    }
    out
}

fn word(
    span: Span,
    text: &str,
    tuple: &mut Option<(Span, Vec<Above>)>,
    out: &mut Vec<(Span, Token)>,
    messages: &mut Messages,
) {
    let (ground, digits) = match text.strip_prefix('~') {
        Some(rest) => (true, if rest.is_empty() { "0" } else { rest }),
        None => (false, text),
    };
    let starts_like_a_number = digits.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let number = digits
        .parse::<f64>()
        .ok()
        .filter(|n| starts_like_a_number && n.is_finite());
    match (tuple, number) {
        (Some((_, numbers)), Some(metres)) => numbers.push(Above { metres, ground }),
        (Some((_, numbers)), None) => {
            let message = format!("`{text}` is not a number");
            messages.error(
                span,
                message,
                "points are numbers between parentheses, as (1.5 -2 0)",
            );
            numbers.push(Above { metres: 0.0, ground });
        }
        (None, Some(number)) if !ground => out.push((span, Token::Value(Value::Number(number)))),
        (None, Some(metres)) => {
            out.push((span, Token::Value(Value::Tuple(vec![Above { metres, ground }]))));
        }
        (None, None) => out.push((span, Token::Value(Value::Word(text.to_owned())))),
    }
}
