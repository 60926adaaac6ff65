//! Files that would end the process, take too long, or give a wrong scene in silence.

use crate::common::{read, read_text, told};
use std::path::Path;
use vellus_usd::Options;

const CURVES: &str = "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
    point3f[] points = [(0,0,0), (1,0,0)] float[] widths = [1, 1] }";

fn strands(body: &str) -> usize {
    let (scene, _) = read_text(body, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{body}"));
    scene.strands.len()
}

fn error_of(body: &str) -> String {
    let Err(error) = read_text(body, &Options::default()) else { panic!("it was read: {body}") };
    error.to_string()
}

/// A stage of these layers. The first is the root.
fn layers(files: &[(&str, String)]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, body) in files {
        std::fs::write(folder.path().join(name), format!("#usda 1.0\n{body}")).unwrap();
    }
    let top = folder.path().join(files[0].0);
    (folder, top)
}

/// `openusd` composes the classes of a prim and of its parent first. In a circle that would not end.
#[test]
fn circles_of_classes_are_errors() {
    let child = format!("{{ {CURVES} }}");
    for arc in ["inherits", "specializes"] {
        let circles = [
            format!("def \"S\" ( {arc} = </S> ) {child}"),
            format!("def \"S\" ( prepend {arc} = [</A>, </S>] ) {child} class \"A\" {{}}"),
            format!("def \"S\" ( {arc} = </T> ) {child} def \"T\" ( {arc} = </S> ) {child}"),
            format!(
                "class \"A\" ( {arc} = </B> ) {child} class \"B\" ( {arc} = </A> ) {child}
                def \"S\" ( {arc} = </A> ) {child}"
            ),
            format!("def \"S\" ( inherits = </T> ) {child} def \"T\" ( specializes = </S> ) {child}"),
            format!("def \"S\" ( {arc} = </S/t> ) {{ def \"t\" {child} {CURVES} }}"),
            format!("def \"S\" {{ def \"t\" ( {arc} = </S> ) {child} }}"),
            format!("def \"S\" {{ def \"t\" ( {arc} = <../t> ) {child} }}"),
            format!("def \"S\" {{ def \"t\" ( {arc} = <../u> ) {child} def \"u\" ( {arc} = <../t> ) {child} }}"),
            format!(
                "def \"S\" ( variants = {{ string v = \"x\" }} prepend variantSets = \"v\" ) {{
                    variantSet \"v\" = {{ \"x\" ( {arc} = </S> ) {child} }} }}"
            ),
            format!("def \"S\" ( references = </T> ) {child} def \"T\" ( {arc} = </S> ) {child}"),
            format!("def \"S\" ( references = </T> ) {child} class \"T\" ( {arc} = </T> ) {child}"),
            format!(
                "def \"S\" ( references = </T> ) {{}}
                class \"T\" {{ def \"a\" ( {arc} = </T/b> ) {child} def \"b\" ( {arc} = </T/a> ) {child} }}"
            ),
        ];
        for body in circles {
            let error = error_of(&body);
            assert!(error.contains("itself") || error.contains("cycle"), "{error}\n{body}");
        }
    }
    // Through another layer. `openusd` ignores such a circle of specializes.
    let circle = format!("def \"T\" ( inherits = </U> ) {child} def \"U\" ( inherits = </T> ) {child}");
    let top = "def \"S\" ( references = @t.usda@</T> ) {}".to_owned();
    let (_folder, top) = layers(&[("top.usda", top), ("t.usda", circle)]);
    let error = read(&top, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("itself") || error.contains("cycle"), "{error}");
    // Without a circle.
    let no_circles = [
        format!("class \"A\" {child} class \"B\" ( inherits = </A> ) {{}} def \"S\" ( inherits = [</A>, </B>] ) {{}}"),
        format!("def \"S\" {{ class \"a\" {child} def \"t\" ( inherits = </S/a> ) {{}} }}"),
        format!(
            "class \"A\" {{ def \"x\" ( inherits = </A/y> ) {{}} class \"y\" {child} }}
            def \"S\" ( references = </A> ) {{}}"
        ),
        format!("def \"S\" ( inherits = </none> ) {child}"),
    ];
    for body in no_circles {
        assert_eq!(strands(&body), 1, "{body}");
    }
    let chain = |n: usize| {
        let links: String = (1..n).map(|i| format!("class \"A{i}\" ( inherits = </A{}> ) {{}}\n", i - 1)).collect();
        format!("class \"A0\" {child} {links} def \"S\" ( inherits = </A{}> ) {{}}", n - 1)
    };
    assert_eq!(strands(&chain(60)), 1);
    assert!(error_of(&chain(2000)).contains("a chain of more than 100 prims that inherit"));
}

/// `openusd` does not find these circles: it would be busy without end, or overflow the stack.
#[test]
fn circles_of_references_and_classes_are_errors() {
    let child = format!("{{ {CURVES} }}");
    let circles = [
        vec![(
            "top.usda",
            format!(
                "over \"S\" ( references = </U/k/c> ) {{}}
                def \"T\" ( references = </S/k> inherits = </T> ) {{ def \"k\" ( references = </S> ) {child} }}
                def \"U\" ( references = </T/k/c> ) {{ def \"k\" ( inherits = </U> ) {child} }}"
            ),
        )],
        vec![(
            "top.usda",
            format!(
                "def \"S\" ( references = </U/k/c> ) {{ def \"k\" ( inherits = </T/k> ) {child} }}
                def \"T\" ( inherits = </U/k> references = </S/k> ) {{}} class \"U\" ( references = </T> ) {child}"
            ),
        )],
        // Only references, to ever deeper prims.
        vec![
            ("top.usda", "( subLayers = [@b.usda@] ) over \"S\" ( references = @b.usda@</T/k> ) {}".into()),
            (
                "b.usda",
                "class \"T\" ( variants = { string v = \"x\" } prepend variantSets = \"v\" ) {
                    variantSet \"v\" = { \"x\" ( payload = @top.usda@</S> ) {} } } def \"U\" ( references = </S> ) {}"
                    .into(),
            ),
        ],
        // The last layer closes the circle.
        vec![
            (
                "top.usda",
                "def \"S\" ( references = @b.usda@</T> ) {} class \"C\" ( references = @b.usda@</T/k> ) {}".into(),
            ),
            ("b.usda", format!("def \"T\" {{ def \"k\" ( inherits = </C> payload = @`\"c.usda\"`@</D> ) {child} }}")),
            ("c.usda", "def \"D\" ( specializes = </C> ) {}".into()),
        ],
        // A relationship from a class, to a prim whose classes form a circle.
        vec![(
            "top.usda",
            format!(
                "def \"S\" ( inherits = </P> ) {child} class \"P\" {{ rel material:binding = </Q/k> }}
                class \"Q\" ( inherits = [</R/k>, </T>] ) {{}} class \"T\" ( inherits = </R/k/c> ) {{}}"
            ),
        )],
    ];
    for files in circles {
        let (_folder, top) = layers(&files);
        let error = told(read(&top, &Options::default()));
        // A circle that goes deeper each time is a chain.
        assert!(error.contains("itself") || error.contains("a chain of more"), "{error}\n{files:?}");
    }
    // Without a circle: classes that layers imply in others, deep references, and the same names everywhere.
    let no_circles = [
        vec![
            (
                "top.usda",
                "def \"S\" ( references = @b.usda@</S> inherits = </C> ) { over \"c\" {} }
                class \"C\" {}"
                    .into(),
            ),
            (
                "b.usda",
                format!(
                    "def \"S\" ( inherits = </C> ) {{ def \"a\" ( inherits = </S/c> ) {{}} class \"c\" {child} }}
                    class \"C\" ( references = @c.usda@</S> ) {{}}"
                ),
            ),
            ("c.usda", "def \"S\" ( inherits = </C> ) {} class \"C\" {}".into()),
        ],
        vec![
            ("top.usda", "def \"S\" { def \"a\" ( references = @b.usda@</T/S/a> ) {} }".into()),
            (
                "b.usda",
                format!(
                    "class \"T\" {{ class \"S\" {{ class \"a\" ( references = </T/b> ) {{}} }}
                        class \"b\" ( inherits = </D/S> ) {{}} }}
                    class \"D\" {{ class \"S\" {child} }}"
                ),
            ),
        ],
    ];
    for files in no_circles {
        let (_folder, top) = layers(&files);
        let (scene, _) = read(&top, &Options::default()).unwrap_or_else(|error| panic!("{error}\n{files:?}"));
        assert_eq!(scene.strands.len(), 1, "{files:?}");
    }
}

/// What looks like a comment or a string to one lexer and not to the other would hide structure from the checks.
#[test]
fn nothing_hides_from_the_checks() {
    let deep = "def \"a\" {".repeat(20_000);
    let dictionary = format!("( customData = {{ {} ", "dictionary d = { ".repeat(20_000));
    for hidden in
        ["# \"\r", "/* \" */", "/* # */", "( doc = \"\"\"\\\"\"\"\" )", "( doc = '\\'\\\\' )", "#\n", "// '''\r"]
    {
        for body in [&deep, &dictionary] {
            assert!(error_of(&format!("{hidden} {body}")).contains("more than 500 brackets"), "{hidden}");
        }
    }
    assert!(error_of(&format!("# \r def \"S\" ( inherits = <> ) {{ {CURVES} }}")).contains("itself"));
    let nested = format!("`{}`", "if(".repeat(10_000));
    for expression in [
        format!("( expressionVariables = {{ string A = \"{nested}\" }} )"),
        format!("def \"S\" ( references = @{nested}@ ) {{}}"),
        format!("( subLayers = [@{nested}@] )"),
        format!("def \"S\" ( variants = {{ string v = '{nested}' }} ) {{}}"),
    ] {
        assert!(error_of(&expression).contains("an expression has more than 100"), "{expression:.60}");
    }
    let twice = |i: i32| format!("string V{i} = '`\"${{V{}}}${{V{}}}\"`'\n", i + 1, i + 1);
    let variables: String = (0..40).map(twice).collect();
    let bomb = format!("( expressionVariables = {{ {variables} string V40 = 'x' }} subLayers = [@`${{V0}}`@] )");
    assert!(error_of(&bomb).contains("more than 32 times"), "{}", error_of(&bomb));
}

/// Programs write JSON and code into strings.
#[test]
fn strings_may_have_many_escapes() {
    for unit in ["\\\"", "\\\"'", "\\\\", "\\n"] {
        let text = format!("def \"S\" {{ custom string note = \"{}\" {CURVES} }}", unit.repeat(100_000));
        assert_eq!(strands(&text), 1);
    }
    let triple = format!("def \"S\" {{ custom string note = \"\"\"{}x\"\"\" {CURVES} }}", "\"a ".repeat(100_000));
    assert_eq!(strands(&triple), 1);
}

#[test]
fn comments_of_all_kinds_are_read() {
    let text = CURVES.replace("(0,0,0)", "(.5, 1., -.5) /* Bob's # \" groom */").replace("float[]", "// 'a\n float[]");
    let text = format!("# it's\r{text} /** /* **/ # end");
    let (scene, _) = read_text(&text, &Options::default()).unwrap();
    assert_eq!(scene.strands[0].points[0].to_array(), [0.5, 1.0, -0.5, 0.5]);
}

/// The x of the second point at a time.
fn x_at(file: &Path, time: f64) -> f32 {
    let options = Options { frame: Some(time), ..Options::default() };
    read(file, &options).unwrap().0.strands[0].points[1].to_array()[0]
}

/// OpenUSD 26.11 sorts samples, and the last of equal times wins.
#[test]
fn samples_may_have_any_order() {
    let points = |samples: &str| {
        let samples = samples.split_whitespace().map(|sample| {
            let (time, x) = sample.split_once(':').unwrap();
            format!("{time}: [(0,0,0), ({x},0,0)], ")
        });
        let samples = samples.collect::<String>();
        CURVES.replace("points = [(0,0,0), (1,0,0)]", &format!("points.timeSamples = {{ {samples} }}"))
    };
    for (samples, expected) in [
        ("5:5 1:1 3:3", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ("1:1 3:3 5:5", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ("3:3 5:9 5:5 1:7 1:1", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ("5:1 1:5", [5.0, 4.0, 3.0, 2.0, 1.0]),
        ("1e1:7 .5e1:5 1.:1", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ("5:5 -1:-1 1:1", [1.0, 2.0, 3.0, 4.0, 5.0]),
    ] {
        let (_folder, file) = layers(&[("a.usda", points(samples))]);
        for (time, x) in (1..=5).zip(expected) {
            assert_eq!(x_at(&file, f64::from(time)), x, "{samples} at {time}");
        }
    }
    for bad in ["nan:1", "inf:1", "1:1 -inf:2", "1e400:1"] {
        assert!(error_of(&points(bad)).contains("a time is no finite number"), "{bad}");
    }
    // In a binary layer the times are a list of their own, which no program writes unsorted.
    let folder = tempfile::tempdir().unwrap();
    let [text, binary] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    let write = |samples: &str| {
        std::fs::write(&text, format!("#usda 1.0\n{}", points(samples))).unwrap();
        let stage = openusd::usd::Stage::builder().open(text.to_str().unwrap()).unwrap();
        stage.root_layer().export(binary.to_str().unwrap()).unwrap();
    };
    write("1:1 3:3 5:5");
    assert_eq!(x_at(&binary, 2.0), 2.0);
    for bad in ["5:5 1:1 3:3", "1:1 1:2"] {
        write(bad);
        let error = read(&binary, &Options::default()).unwrap_err().to_string();
        assert!(error.contains("each later than the one before"), "{error}");
    }
}

/// Composition compares the references of a prim with each other.
#[test]
fn lists_of_arcs_and_chains_of_layers_are_bounded() {
    let many = "@a.usda@, ".repeat(5000);
    for arc in ["references", "payload", "prepend references"] {
        assert!(error_of(&format!("def \"S\" ( {arc} = [{many}] ) {{}}")).contains("more than 1000 references"));
    }
    assert!(error_of(&format!("( subLayers = [{many}] )")).contains("more than 1000"));
    // A relationship may have as many targets as it likes.
    let targets = "</c>, ".repeat(5000);
    assert_eq!(strands(&format!("{CURVES} def \"S\" {{ rel r = [{targets}] }}")), 1);
}

/// Each level has the level below ten times. Nothing is composed more than once, so four levels take no longer than
/// their 10,000 strands, and twelve are refused at once.
#[test]
fn levels_of_instances_are_composed_once() {
    let levels = |count: usize, arc: &str| {
        let mut body = format!("class \"L0\" {{ {CURVES} }}\n");
        for level in 1..=count {
            let kind = if level == count { "def" } else { "class" };
            let ten: String = (0..10)
                .map(|i| format!("def \"r{i}\" ( instanceable = true {arc} = </L{}> ) {{}}\n", level - 1))
                .collect();
            body += &format!("{kind} \"L{level}\" {{ {ten} }}\n");
        }
        body
    };
    for arc in ["inherits", "references", "specializes", "payload"] {
        assert_eq!(strands(&levels(3, arc)), 1000, "{arc}");
        let started = std::time::Instant::now();
        let error = error_of(&levels(12, arc));
        assert!(error.contains("sites"), "{arc}: {error}");
        // It would take minutes to compose as many sites as are allowed.
        assert!(started.elapsed() < std::time::Duration::from_secs(20), "{arc}: {:?}", started.elapsed());
    }
}
