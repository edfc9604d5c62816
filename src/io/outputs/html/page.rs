//! HTML pages: document head, the one style sheet, and escaping of text.
//!
//! Consumes titles and texts, which may come from files; produces HTML without scripts, fonts or network access, in the reader's
//! light or dark scheme; printed black on white, no figure broken over two pages.

use crate::io::outputs::words::printable::with_short_numbers;

/// Text that means nothing but itself, in a page or in an attribute of it.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            letter => safe.push(letter),
        }
    }
    safe
}

/// Text for an attribute of the page, plus and minus as one sign.
pub fn attribute(text: &str) -> String {
    escaped(&with_short_numbers(&text.replace("+-", "\u{b1}")))
}

/// The same between tags; what stands in a pair of backticks is code.
pub fn words(text: &str) -> String {
    let text = attribute(text);
    let mut parts = text.split('`');
    let mut marked = parts.next().unwrap_or_default().to_owned();
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(after) => marked.push_str(&format!("<code>{code}</code>{after}")),
            None => marked.push_str(&format!("`{code}")),
        }
    }
    marked
}

/// How a page begins, up to its first heading; the title is made safe.
pub fn head(title: &str) -> String {
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>{title}</title>\n<style>\n{STYLE}</style></head><body>\n"
    )
}

/// How it ends.
pub const FOOT: &str = "</body></html>\n";

/// Colours of curves are those of `chart`, lighter on a dark ground.
const STYLE: &str = "\
:root{--ground:#fff;--ink:#1a1c1f;--faint:#5d646c;--rule:#d4d8dc;--box:#f4f5f7;
--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#cc79a7;--c4:#56b4e9;--c5:#e69f00;--c6:#000}
@media (prefers-color-scheme:dark){:root{--ground:#15171a;--ink:#e4e6e9;--faint:#a2a9b1;--rule:#3b4047;--box:#202329;
--c0:#4aa8e0;--c1:#f08a3c;--c2:#2cc79b;--c3:#e3a0c5;--c4:#9bd4f5;--c5:#f2bd4a;--c6:#fff}}
body{font:16px/1.5 system-ui,sans-serif;background:var(--ground);color:var(--ink);max-width:1180px;margin:2em auto;padding:0 1em}
h1{font-size:1.6em;margin:0 0 .3em}h2{font-size:1.25em;margin:2em 0 .4em;border-bottom:1px solid var(--rule)}
h3{font-size:1.05em;margin:1.4em 0 .3em}p,ul,ol{max-width:72ch}.faint,figcaption{color:var(--faint)}
pre{background:var(--box);padding:1em;overflow-x:auto}svg{max-width:100%;height:auto}
.answer{background:var(--box);border-left:5px solid var(--c0);padding:.8em 1.2em;margin:1em 0;max-width:none}
.answer li{margin:.5em 0}.answer .cause{font-size:1.12em;font-weight:600}
.side{display:grid;grid-template-columns:1fr 1fr;gap:.6em 1em}@media (max-width:820px){.side{grid-template-columns:1fr}}
figure{margin:.5em 0;break-inside:avoid}figcaption{font-size:.86em}figcaption b{color:var(--ink);margin-right:.6em}
figure svg{display:block;width:100%}figure text{font-family:system-ui,sans-serif;fill:var(--ink)}
.key{white-space:nowrap;margin-right:.6em}.key::before{content:\"\";display:inline-block;vertical-align:middle;margin-right:.3em;
background:var(--c);print-color-adjust:exact;-webkit-print-color-adjust:exact}
.key.line::before{width:1.5em;height:.2em}.key.dot::before{width:.55em;height:.55em;border-radius:50%}
.c0{--c:var(--c0)}.c1{--c:var(--c1)}.c2{--c:var(--c2)}.c3{--c:var(--c3)}.c4{--c:var(--c4)}.c5{--c:var(--c5)}.c6{--c:var(--c6)}
figure [stroke=\"#0072B2\"]{stroke:var(--c0)}figure [fill=\"#0072B2\"]{fill:var(--c0)}
figure [stroke=\"#D55E00\"]{stroke:var(--c1)}figure [fill=\"#D55E00\"]{fill:var(--c1)}
figure [stroke=\"#009E73\"]{stroke:var(--c2)}figure [fill=\"#009E73\"]{fill:var(--c2)}
figure [stroke=\"#CC79A7\"]{stroke:var(--c3)}figure [fill=\"#CC79A7\"]{fill:var(--c3)}
figure [stroke=\"#56B4E9\"]{stroke:var(--c4)}figure [fill=\"#56B4E9\"]{fill:var(--c4)}
figure [stroke=\"#E69F00\"]{stroke:var(--c5)}figure [fill=\"#E69F00\"]{fill:var(--c5)}
figure [stroke=\"#000000\"]{stroke:var(--c6)}
table{border-collapse:collapse;font-size:.9em;font-variant-numeric:tabular-nums;margin:.6em 0}
th,td{padding:.18em .7em;text-align:right;border-bottom:1px solid var(--rule);vertical-align:top}
th{color:var(--faint);font-weight:600}th[scope=row]{color:var(--ink);text-align:left;white-space:nowrap}
th[scope=row]~td:not(.words){white-space:nowrap}td.words,th.words{text-align:left}
td.words{min-width:7em}td.words:last-child{min-width:16em}
td.better{color:var(--c2);font-weight:600}
td.worse{color:var(--c1);font-weight:600}.wide{overflow-x:auto}td.odds{text-align:left;white-space:nowrap}
.interval{display:block;font-weight:400;font-size:.86em;color:var(--faint);white-space:nowrap}
.bar{display:inline-block;height:.8em;min-width:1px;background:var(--c0);print-color-adjust:exact;
-webkit-print-color-adjust:exact}
.bar.less{background:var(--c1)}
@media print{:root{--ground:#fff;--ink:#000;--faint:#444;--rule:#bbb;--box:#fff;
--c0:#0072b2;--c1:#d55e00;--c2:#009e73;--c3:#cc79a7;--c4:#56b4e9;--c5:#e69f00;--c6:#000}
body{margin:0;max-width:none;font-size:11px}h2,h3{break-after:avoid}tr,.answer{break-inside:avoid}
table{font-size:8px}th,td{padding:.15em .4em}.wide{overflow:visible}}
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_files_say_is_text_and_nothing_else() {
        let safe = escaped("<script src='x'>a & \"b\"</script>");
        assert_eq!(safe, "&lt;script src=&#39;x&#39;&gt;a &amp; &quot;b&quot;&lt;/script&gt;");
        assert_eq!(words("`a<b` +- `c` or `d"), "<code>a&lt;b</code> \u{b1} <code>c</code> or `d");
        assert_eq!(attribute("`a` +- \"b"), "`a` \u{b1} &quot;b");
        let page = head("a<b");
        assert!(page.contains("<title>a&lt;b</title>") && !page.contains("http") && !page.contains("<script"));
        assert_eq!(page.matches('{').count(), page.matches('}').count());
    }
}
