//! The scan counts what the parser finds; each limit is kept, and what is just below it is read.

use super::scan::{Counts, scan};
use super::*;
use proptest::prelude::*;

const NODES: u32 = 1_000_000;

/// What a parsed document holds.
fn counted(document: &Document<'_>) -> Counts {
    let mut counts = Counts::default();
    for element in document.descendants().filter(roxmltree::Node::is_element) {
        let attributes = element.attributes().len();
        counts.elements += 1;
        counts.attributes += attributes;
        counts.attributes_of_one = counts.attributes_of_one.max(attributes);
        // Among its ancestors are itself and the root, which is no element.
        counts.depth = counts.depth.max(element.ancestors().count() - 1);
    }
    counts
}

fn refusal(text: &str) -> String {
    parse(text, NODES).expect_err("refused").to_string()
}

fn with_attributes(count: usize) -> String {
    let all: String = (0..count).map(|i| format!(" a{i}='{i}'")).collect();
    format!("<a>\n <b{all}/></a>")
}

#[test]
fn an_element_of_many_attributes_is_refused_at_its_place() {
    parse(&with_attributes(ATTRIBUTES_MAX), NODES).expect("as many as may be");
    for count in [ATTRIBUTES_MAX + 1, 200_000] {
        let error = parse(&with_attributes(count), NODES).expect_err("too many");
        assert!(error.to_string().contains("more than 64 attributes"), "{error}");
        assert_eq!(error.position(), (2, 2));
    }
}

#[test]
fn elements_in_each_other_are_bounded() {
    let nested = |depth| format!("{}{}", "<a>".repeat(depth), "</a>".repeat(depth));
    parse(&nested(DEPTH_MAX), NODES).expect("as deep as may be");
    assert!(refusal(&nested(DEPTH_MAX + 1)).contains("more than 512 elements are nested"));
    assert!(refusal(&"<a>".repeat(1_000_000)).contains("more than 512 elements are nested"));
    // Beside each other they are not deep.
    parse(&format!("<a>{}</a>", "<b></b><c/>".repeat(5_000)), NODES).expect("flat");
}

#[test]
fn namespaces_are_bounded_over_the_whole_text() {
    let declaring = |count: usize| {
        let each: String =
            (0..count).map(|i| format!("<n{i}:b\txmlns:n{i}=\"u{i}\" xmlnot=''/>")).collect();
        format!("<a>{each}</a>").replace(" xmlnot=''", "")
    };
    parse(&declaring(NAMESPACES_MAX), NODES).expect("as many as may be");
    assert!(refusal(&declaring(NAMESPACES_MAX + 1)).contains("more than 64 namespaces"));
}

#[test]
fn nodes_and_attributes_are_bounded_in_all() {
    let error = parse("<a><b/><b/><b/></a>", 3).expect_err("four elements");
    assert!(error.to_string().contains("more than 3 elements"), "{error}");
    let error = parse("<a x='' y=''><b x='' y=''/></a>", 3).expect_err("four attributes");
    assert!(error.to_string().contains("more than 3 attributes"), "{error}");
}

#[test]
fn declarations_and_damage_are_refused_at_their_line() {
    let error = parse("\n<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", NODES).expect_err("a DTD");
    assert_eq!(error, XmlError::Declaration { line: 2 });
    for (text, line) in [("<a>\n</b>", 2), ("<a>\n\n<!x></a>", 3), ("", 1), ("<a b='", 1)] {
        let error = parse(text, NODES).expect_err(text);
        assert!(matches!(error, XmlError::Syntax { .. }), "{text}: {error}");
        assert_eq!(error.position().0, line, "{text}: {error}");
    }
}

/// Pieces that put quotes, brackets and ends where they end nothing.
fn piece() -> impl Strategy<Value = String> {
    let fixed = [
        "<b/>",
        "<b />",
        "<b>",
        "</b>",
        "<c x='1'>",
        "</c>",
        "<c y=\">\" z='\"/>'/>",
        "text",
        "\"",
        "'",
        ">",
        "/>",
        "<!-- <b x='1'> -->",
        "<!--'-->",
        "<![CDATA[<b x=']]>",
        "<?p <b x='?>",
        "ä",
        "<b x = 'ä' />",
        "<b\n\tx='&lt;'\r\n>",
        "<!-->",
        "]]",
        "?>",
        "=",
    ];
    prop_oneof![
        prop::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        "[a-z<>'\"/=!? -]{0,6}"
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn what_the_parser_accepts_was_counted_right(pieces in prop::collection::vec(piece(), 0..12)) {
        let text = format!("<a>{}</a>", pieces.concat());
        let counts = scan(&text, NODES as usize);
        if let Ok(document) = Document::parse(&text) {
            prop_assert_eq!(counts, Ok(counted(&document)), "{}", text);
        }
    }

    #[test]
    fn balanced_texts_are_accepted_and_counted(
        inside in prop::collection::vec(
            prop::sample::select(vec![
                "<b/>", "<b><c/></b>", "<c y=\">\" z='\"/>'/>", "t\"'>", "<!-- <b x='1'> -->",
                "<![CDATA[<b x=']]>", "<?p <b x='?>", "<b\n x = 'ä' ><d/>t</b >",
            ]),
            0..12,
        ),
    ) {
        let text = format!("<?xml version='1.0'?><!--<--><a>{}</a>", inside.concat());
        let document = Document::parse(&text).expect("sound");
        prop_assert_eq!(scan(&text, NODES as usize), Ok(counted(&document)), "{}", text);
    }
}
