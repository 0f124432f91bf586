//! Reads headings, anchors and links of Markdown pages, without the code in them.
//!
//! The subset of the pages here: ATX headings, fenced and indented code, inline links and images,
//! reference definitions, `id`, `href` and `src` of HTML tags.

use std::collections::BTreeMap;

#[derive(Default)]
pub struct Page {
    /// Level and text of each heading.
    pub headings: Vec<(usize, String)>,
    /// Index of the next heading, and value, of each `id` in HTML tags.
    pub ids: Vec<(usize, String)>,
    /// Targets of links and pictures, with the number of the line where their block begins.
    pub links: Vec<(usize, String)>,
}

/// Width of a list marker with its spaces, such as `- ` or `10. `.
fn list_marker(line: &str) -> Option<usize> {
    let digits = line.len() - line.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let rest = match digits {
        0 => line.strip_prefix(['-', '*', '+'])?,
        _ => line[digits..].strip_prefix(['.', ')'])?,
    };
    rest.starts_with(' ').then(|| line.len() - rest.trim_start().len())
}

/// Blocks of prose with their first line's number: paragraphs, list items, table rows and headings.
fn prose(text: &str) -> Vec<(usize, String)> {
    let mut blocks: Vec<(usize, String)> = Vec::new();
    let (mut fence, mut after_blank, mut in_code) = (None::<&str>, true, false);
    // Indentation of the content of the innermost list item.
    let mut content = 0;
    for (number, line) in text.lines().enumerate() {
        let trimmed = line.trim_start();
        let indentation = line.len() - trimmed.len();
        if let Some(open) = fence {
            if trimmed.starts_with(open) {
                fence = None;
            }
            continue;
        }
        if let Some(mark) = ["```", "~~~"].into_iter().find(|mark| trimmed.starts_with(mark)) {
            (fence, after_blank) = (Some(mark), true);
            continue;
        }
        if trimmed.is_empty() {
            after_blank = true;
            continue;
        }
        if after_blank && indentation < content {
            content = indentation;
        }
        in_code = (in_code || after_blank) && indentation >= content + 4;
        if in_code {
            continue;
        }
        let marker = list_marker(trimmed);
        if let Some(width) = marker {
            content = indentation + width;
        }
        match blocks.last_mut() {
            Some((_, block)) if !after_blank && marker.is_none() && !trimmed.starts_with(['#', '|', '>', '[']) => {
                block.push(' ');
                block.push_str(trimmed);
            }
            _ => blocks.push((number + 1, trimmed.to_owned())),
        }
        // A heading is one line.
        after_blank = trimmed.starts_with('#');
    }
    blocks
}

/// Splits a block at its code spans: prose and code in turn, beginning with prose.
fn split_code(block: &str) -> Vec<&str> {
    let (mut pieces, mut start, mut at) = (Vec::new(), 0, 0);
    while let Some(open) = block[at..].find('`').map(|offset| at + offset) {
        let width = block[open..].len() - block[open..].trim_start_matches('`').len();
        let inside = open + width;
        let mut close = inside;
        let end = loop {
            let Some(next) = block[close..].find('`').map(|offset| close + offset) else { break None };
            let run = block[next..].len() - block[next..].trim_start_matches('`').len();
            if run == width {
                break Some(next);
            }
            close = next + run;
        };
        at = inside;
        if let Some(end) = end {
            pieces.extend([&block[start..open], &block[inside..end]]);
            (start, at) = (end + width, end + width);
        }
    }
    pieces.push(&block[start..]);
    pieces
}

/// Targets of `](target)` and `](target "title")`.
fn inline_targets(prose: &str) -> impl Iterator<Item = &str> {
    prose.match_indices("](").map(|(at, _)| {
        let rest = &prose[at + 2..];
        let mut depth = 0;
        let end = rest.find(|c| match c {
            '(' => {
                depth += 1;
                false
            }
            ')' if depth > 0 => {
                depth -= 1;
                false
            }
            c => c == ')' || c == ' ',
        });
        &rest[..end.unwrap_or(rest.len())]
    })
}

/// Values of an attribute in HTML tags.
fn attribute<'a>(prose: &'a str, name: &str) -> impl Iterator<Item = &'a str> {
    let start = format!("{name}=\"");
    let tags = prose.split('<').skip(1).filter_map(|tag| tag.split('>').next());
    tags.filter_map(move |tag| tag.split_once(&start)?.1.split('"').next())
}

impl Page {
    pub fn read(text: &str) -> Self {
        let mut page = Page::default();
        for (line, block) in prose(text) {
            let pieces = split_code(&block);
            // A character that is in no target stands for code.
            let prose: String = pieces.iter().step_by(2).copied().collect::<Vec<_>>().join("\u{fffc}");
            let level = block.len() - block.trim_start_matches('#').len();
            if (1..=6).contains(&level) && block[level..].starts_with(' ') {
                page.headings.push((level, heading_text(&pieces.concat()[level..])));
            }
            page.ids.extend(attribute(&prose, "id").map(|id| (page.headings.len(), id.to_owned())));
            let definition = prose.strip_prefix('[').and_then(|rest| rest.split_once("]: ")).map(|(_, target)| target);
            let targets = inline_targets(&prose).chain(definition);
            let targets = targets.chain(attribute(&prose, "href")).chain(attribute(&prose, "src"));
            page.links.extend(targets.map(|target| (line, target.to_owned())));
        }
        page
    }

    /// Anchors by the rule of GitHub.
    pub fn github_slugs(&self) -> Vec<String> {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        let slug = |heading: &str| -> String {
            let kept = |c: &char| c.is_alphabetic() || c.is_ascii_digit() || "_- ".contains(*c);
            heading.to_lowercase().chars().filter(kept).map(|c| if c == ' ' { '-' } else { c }).collect()
        };
        let mut numbered = |slug: String| {
            let count = counts.entry(slug.clone()).or_default();
            *count += 1;
            if *count == 1 { slug } else { format!("{slug}-{}", *count - 1) }
        };
        self.headings.iter().map(|(_, heading)| numbered(slug(heading))).collect()
    }

    /// Anchors by the rule of mdBook 0.5, which never gives one twice.
    pub fn mdbook_slugs(&self) -> Vec<String> {
        let slug = |heading: &str| -> String {
            let kept = |c: &char| c.is_alphanumeric() || c.is_whitespace() || "_-".contains(*c);
            heading.to_lowercase().chars().filter(kept).map(|c| if c.is_whitespace() { '-' } else { c }).collect()
        };
        let mut slugs: Vec<String> = Vec::new();
        for (_, heading) in &self.headings {
            let plain = slug(heading);
            let numbered = (1..).map(|count| format!("{plain}-{count}"));
            let free = [plain.clone()].into_iter().chain(numbered).find(|slug| !slugs.contains(slug));
            slugs.extend(free);
        }
        slugs
    }
}

/// Text of a heading, without the targets of its links.
fn heading_text(heading: &str) -> String {
    let mut text = heading.trim().trim_end_matches('#').trim_end().to_owned();
    while let Some(start) = text.find("](") {
        let Some(length) = text[start..].find(')') else { break };
        text.replace_range(start..=start + length, "");
    }
    text
}

#[test]
fn links_and_headings_are_found_outside_code() {
    let page = Page::read(concat!(
        "# A [title](a.md) with `code_1`\n\nText over\nlines: [a\nb](b.md#c), `[not](x.md)` and ``[`](y.md)``.\n",
        "![picture](p.svg \"title\")\n\n    # [code](z.md)\n\n```sh\n# [code](z.md)\n```\n- item\n\n  [in item](c.md)\n\n",
        "      [code](z.md)\n\n## Again\n| `a` | [cell](d.md) |\n| [second](e(1).md) | `|` |\n## Again\n<a id=\"x\"></a>\n\n",
        "[definition]: f.md\n",
    ));
    let links: Vec<_> = page.links.iter().map(|(line, target)| (*line, target.as_str())).collect();
    let expected = [(1, "a.md"), (3, "b.md#c"), (3, "p.svg"), (15, "c.md")];
    assert_eq!(links[..4], expected);
    assert_eq!(links[4..], [(20, "d.md"), (21, "e(1).md"), (25, "f.md")]);
    assert_eq!(page.ids, [(3, "x".to_owned())]);
    assert_eq!(page.headings.iter().map(|(level, _)| *level).collect::<Vec<_>>(), [1, 2, 2]);
    assert_eq!(page.github_slugs(), ["a-title-with-code_1", "again", "again-1"]);
    assert_eq!(page.mdbook_slugs(), page.github_slugs());
}
