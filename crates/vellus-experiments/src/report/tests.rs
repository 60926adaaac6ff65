use super::*;
use crate::Side;

/// Text that would be markup if it was not escaped.
const TEXT: &str = "a < b & \"c\" 'd' <i>e</i>";

fn side(name: &str) -> Side {
    Side { file: format!("{name}.png"), zoom: format!("{name}-zoom.png"), label: format!("{name} {TEXT}") }
}

/// An outcome with everything, whose texts are markup.
fn outcome(name: &str, quality: Quality) -> Outcome {
    let mut table = Table::new("numbers", TEXT, &[TEXT, "second"]);
    table.row([TEXT, "1"]);
    let claims = vec![
        Claim::new("The paper claims this", "2.5 ×", 2.5, Verdict::Holds).paper("2 ×").more(TEXT),
        Claim::new("We claim this", "0.7 %", 0.7, Verdict::DoesNotHold).ours("at most 0.5 %").because(TEXT),
        Claim::not_judged(TEXT, TEXT, "no data").paper(TEXT).ours(TEXT),
    ];
    let slider = Slider {
        caption: TEXT.to_owned(),
        size: [80, 60],
        sides: [side("left"), side("right")],
        maps: vec![side("map")],
        zoom: [20, 15, 40, 30],
    };
    let mut outcome = Outcome {
        name: name.to_owned(),
        figure: TEXT.to_owned(),
        title: TEXT.to_owned(),
        quality,
        sliders: vec![slider],
        pictures: vec![Picture::new("chart.png", TEXT).also("chart.svg"), Picture::new("b.png", TEXT).beside()],
        tables: vec![table],
        claims,
        notes: vec![TEXT.to_owned()],
        version: TEXT.to_owned(),
        processor: TEXT.to_owned(),
        ..Outcome::new(TEXT)
    };
    if quality == Quality::Smoke {
        outcome.withhold_verdicts();
    }
    outcome
}

/// The body of a page without its script, and the tags of it in order.
fn tags(page: &str) -> Vec<&str> {
    let body = &page[page.find("<body>").unwrap()..page.find("<script>").unwrap()];
    body.split('<').skip(1).map(|part| part.split_once('>').unwrap().0).collect()
}

/// Elements are closed in order, and attributes are quoted. No text of an outcome becomes markup.
#[test]
fn the_page_is_well_formed() {
    let page = page(&[outcome("hair", Quality::Draft), outcome("cat", Quality::Smoke)]);
    assert!(!page.contains("<i>e") && !page.contains(TEXT) && page.contains(&escaped(TEXT)));
    let mut open = Vec::new();
    for tag in tags(&page) {
        let name = tag.split_whitespace().next().unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "{tag} in {open:?}"),
            None if matches!(name, "img" | "input" | "br") => {}
            None => open.push(name),
        }
        // A paragraph ends where a block begins.
        let is_block = matches!(name, "div" | "table" | "figure" | "details" | "section" | "h2" | "p");
        assert!(!is_block || !open.iter().rev().skip(1).any(|name| *name == "p"), "{name} in {open:?}");
    }
    // The script closes the body.
    assert_eq!(open, ["body"]);
    let ids: Vec<&str> = page.split(" id=\"").skip(1).map(|part| part.split('"').next().unwrap()).collect();
    assert_eq!(ids, ["hair", "cat", "claims"]);
}

/// Every picture says what it shows. The divider has a name, and nothing comes from other places.
#[test]
fn pictures_and_dividers_have_names() {
    let page = page(&[outcome("hair", Quality::Draft)]);
    let images: Vec<&str> = tags(&page).into_iter().filter(|tag| tag.starts_with("img")).collect();
    // Two sides and a map, each also enlarged, and two other pictures.
    assert_eq!(images.len(), 8);
    assert!(
        images.iter().all(|tag| tag.contains(" alt=\"") && !tag.contains("alt=\"\"") && tag.contains("src=\"hair/"))
    );
    assert_eq!(page.matches("type=\"range\"").count(), 1);
    assert!(page.contains("aria-label=\"Divider: left "));
    assert!(page.contains("left:25.00%;top:25.00%;width:50.00%;height:50.00%"));
    assert!(!page.contains("http") && !page.contains("@import") && !page.contains("src=\"/"));
}

/// Pictures come before claims, and claims before tables. The paper's claims and ours have columns of their own.
#[test]
fn pictures_come_first_and_claims_have_columns() {
    let page = page(&[outcome("hair", Quality::Draft)]);
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} is missing"));
    let order = ["<section>", "class=\"stage\"", "class=\"claims\"", "All pictures (2)", "numbers.csv", "</section>"];
    assert!(order.windows(2).all(|pair| at(pair[0]) < at(pair[1])), "{page}");
    let head = "<th>claim</th><th>the paper</th><th>Vellus</th><th>measured</th><th>verdict</th>";
    assert_eq!(page.matches(head).count(), 2);
    let paper = "<td data-as=\"the paper\">2 ×</td><td data-as=\"Vellus\" class=\"none\">–</td><td \
                 data-as=\"measured\">2.5 ×</td><td class=\"v v0\">holds</td>";
    let ours = "<td data-as=\"the paper\" class=\"none\">–</td><td data-as=\"Vellus\">at most 0.5 %</td><td \
                data-as=\"measured\">0.7 %</td><td class=\"v v2\">does not hold</td>";
    // Once in the section, and once in the table of all claims.
    assert_eq!((page.matches(paper).count(), page.matches(ours).count()), (2, 2));
}

#[test]
fn nothing_is_judged_at_smoke_quality() {
    let page = page(&[outcome("hair", Quality::Smoke)]);
    assert!(page.contains("3 not judged at smoke quality</span>") && page.contains("No claim is judged."));
    assert_eq!(page.matches("\">not judged at smoke quality</td>").count(), 6);
    let words = [">holds<", ">better<", ">does not hold<", ">not judged<", " hold</span>"];
    assert!(words.iter().all(|word| !page.contains(word)));
}

/// Without results the page still says what is missing.
#[test]
fn an_empty_page_names_what_was_not_run() {
    let page = page(&[]);
    assert!(page.contains("Not run yet: medulla-tables") && page.contains("convergence, hair"));
    assert!(!page.contains("quality."));
}

/// A factor that our version of the model of 2015 does not show says nothing about the paper's version.
#[test]
fn a_missed_factor_beside_our_baseline_is_not_reproduced() {
    let missed = Verdict::at_least(1.2, 2.0).beside_our_baseline();
    assert_eq!(missed.count(2), "2 not reproduced with our optimised baseline");
    assert_eq!(Claim::new("a", "b", 1.2, missed).or_because("c").why, "c");
    assert_eq!(Verdict::at_least(2.5, 2.0).beside_our_baseline(), Verdict::Better);
    for verdict in Verdict::ALL {
        assert_eq!(serde_json::to_value(verdict).unwrap(), verdict.name());
    }
}
