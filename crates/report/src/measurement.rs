//! A measurement's tables and figures as one page.

use crate::html::escape;
use crate::pack::base64;
use std::fmt::Write as _;

/// What `trolley measure` wrote into a folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasurementPage {
    /// Its title.
    pub title: String,
    /// Its page, Markdown: headings, paragraphs, tables.
    pub text: String,
    /// Its figures.
    pub figures: Vec<Figure>,
}

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The file name in the text.
    pub name: String,
    /// The PNG data.
    pub png: Vec<u8>,
}

impl MeasurementPage {
    /// The text as markup, figures in their places.
    pub(crate) fn markup(&self) -> String {
        let mut out = String::new();
        let mut lines = self.text.lines().peekable();
        while let Some(line) = lines.next() {
            let line = line.trim();
            if let Some(heading) = line.strip_prefix("## ") {
                let _w = write!(out, "<h2>{}</h2>", inline(heading));
            } else if let Some(heading) = line.strip_prefix("# ") {
                let _w = write!(out, "<header><h1>{}</h1></header>", inline(heading));
            } else if line.starts_with("![") {
                out += &self.figure(line);
            } else if line.starts_with('|') {
                out += "<div class=\"wide\"><table>";
                let is_rule = |line: &str| line.chars().all(|c| "|-: ".contains(c));
                let rule = lines.peek().map_or("", |next| next.trim());
                let rule = if is_rule(rule) { rule } else { "" };
                out += &row(line, rule, "th");
                while let Some(next) = lines.next_if(|next| next.trim().starts_with('|')) {
                    if !is_rule(next.trim()) {
                        out += &row(next.trim(), rule, "td");
                    }
                }
                out += "</table></div>";
            } else if !line.is_empty() {
                let mut text = line.to_owned();
                let plain = |next: &&str| {
                    let next = next.trim();
                    !next.is_empty() && !next.starts_with(['|', '#', '!'])
                };
                while let Some(next) = lines.next_if(plain) {
                    text.push(' ');
                    text.push_str(next.trim());
                }
                let _w = write!(out, "<p>{}</p>", inline(&text));
            }
        }
        out
    }

    /// `![caption](file.png)`, with the picture embedded.
    fn figure(&self, line: &str) -> String {
        let parts = line.trim_start_matches("![").split_once("](");
        let Some((caption, file)) = parts else { return String::new() };
        let file = file.trim_end_matches(')');
        let Some(figure) = self.figures.iter().find(|figure| figure.name == file) else {
            return format!("<p class=\"absent\">{} is missing.</p>", escape(file));
        };
        format!(
            "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}\
             </figcaption></figure>",
            escape(caption),
            base64(&figure.png)
        )
    }
}

/// A row of a table. `rule` is the line below its heads: "--:" has a column of numbers.
fn row(line: &str, rule: &str, cell: &str) -> String {
    let numbers: Vec<bool> =
        rule.trim_matches('|').split('|').map(|column| column.trim().ends_with(':')).collect();
    let cells = line.trim_matches('|').split('|').enumerate().map(|(at, text)| {
        let class = if numbers.get(at) == Some(&true) { " class=\"n\"" } else { "" };
        format!("<{cell}{class}>{}</{cell}>", inline(text.trim()))
    });
    format!("<tr>{}</tr>", cells.collect::<String>())
}

/// Text between marks `*`, and links as the names that they have: the page may lie anywhere.
fn emphasised(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, name, file, after)) = link(rest) {
        let _w = write!(out, "{} (<code>{}</code>)", escape(before) + &escape(name), escape(file));
        rest = after;
    }
    out += &escape(rest);
    let parts: Vec<&str> = out.split('*').collect();
    // A mark alone is a sign.
    if parts.len().is_multiple_of(2) {
        return out;
    }
    let part = |(at, part): (usize, &&str)| {
        if at % 2 == 1 { format!("<em>{part}</em>") } else { (*part).to_owned() }
    };
    parts.iter().enumerate().map(part).collect()
}

/// The first `[name](file)`: what is before it, both, and what is after it.
fn link(text: &str) -> Option<(&str, &str, &str, &str)> {
    let (before, rest) = text.split_once('[')?;
    let (name, rest) = rest.split_once("](")?;
    let (file, after) = rest.split_once(')')?;
    Some((before, name, file, after))
}

/// Bold, emphasis, code and links; everything else as it is.
fn inline(text: &str) -> String {
    let mut out = String::new();
    for (at, part) in text.split('`').enumerate() {
        if at % 2 == 1 {
            let _w = write!(out, "<code>{}</code>", escape(part));
            continue;
        }
        for (at, part) in part.split("**").enumerate() {
            let part = emphasised(part);
            out += &if at % 2 == 1 { format!("<b>{part}</b>") } else { part };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    //! Tables, figures and bold are rendered; foreign markup is escaped.

    use super::*;

    #[test]
    fn markdown_of_a_measurement_becomes_markup() {
        let text = "# A <b>\n\nSome **bold** `code`\nand more: *here*, \
                    the [<map>](m/R.md)\n\n| a | b |\n|---|--:|\n| 1 | 2 |\n\n \
                    ![a figure](f.png)\n![another](no.png)\n";
        let figures = vec![Figure { name: "f.png".into(), png: vec![1, 2, 3] }];
        let markup = MeasurementPage { title: "A".into(), text: text.into(), figures }.markup();
        for part in [
            "<h1>A &lt;b&gt;</h1>",
            "<p>Some <b>bold</b> <code>code</code> and more: <em>here</em>, the ",
            "the &lt;map&gt; (<code>m/R.md</code>)</p>",
            "<tr><th>a</th><th class=\"n\">b</th></tr><tr><td>1</td><td class=\"n\">2</td></tr>",
            "src=\"data:image/png;base64,AQID\"",
            "no.png is missing",
        ] {
            assert!(markup.contains(part), "{part}: {markup}");
        }
    }
}
