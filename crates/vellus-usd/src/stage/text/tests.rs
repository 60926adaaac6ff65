//! Tests of the preparation of text layers.

use super::*;
use crate::stage::arc_list::MOST_ARCS;
use crate::stage::arcs::Arc;

fn read(text: &str) -> String {
    String::from_utf8(normalized(text.into()).unwrap().bytes).unwrap()
}

fn error(text: &str) -> String {
    normalized(format!("#usda 1.0\n\n{text}").into()).err().unwrap_or_else(|| panic!("{text}")).0
}

#[test]
fn names_and_paths_are_checked() {
    let good = "#usda 1.0\n( doc = \"\"\"} // </a}> ((( \"\"\" defaultPrim = \"b\" )\n\
                def Xform \"b\" ( references = @./a}<.usda@</b> ) { string s = \"it's } </\" rel r = [</b>] }\n\
                over \"c\" { asset a = @@@x</a}>@@@ string def = 'a}' rel r = <../c{v=x}d> }";
    assert_eq!(read(good), good);
    let bad = ["def Xform \"a}\" {}", "over \"\" {}", "class \"a b\" {}", "rel r = </a}>", "( defaultPrim = 'a}' )"];
    // What hides a name from this lexer and not from the parser would be a hole.
    let hidden =
        ["# \"\r", "/* \" */", "/* ' **/", "// \"\n", "string s = '\\''", "string s = '''\\\\'''", "asset a = @@"];
    for text in bad {
        assert!(error(text).starts_with("line 3: "), "{text}: {}", error(text));
        for hidden in hidden {
            error(&format!("{hidden} {text}"));
        }
    }
    assert!(error("def \"a\" { def \"b\" {} def \"a\" {} over \"b\" {} }").contains("are called b"));
    assert!(error("def \"a\" { def \"b\" {} } def \"c\" { def \"b\" {} } class X \"a\" {}").contains("are called a"));
    assert!(error(&"[".repeat(501)).contains("more than 500 brackets"));
    read(&format!("# {0}\n\"{0}\" /* {0} */", "[".repeat(900)));
    // Text that is cut off does not loop forever.
    for text in ["\"", "'''", "<", "@", "@@@", "\"\\", "def \"", "#", "<\\", "/*", "/", "@@@a@@"] {
        let _ = normalized(text.into());
    }
}

#[test]
fn numbers_get_the_digits_that_the_parser_requires() {
    assert_eq!(read("[.1, -.5e3, +2., (3.e-4,.7)]"), "[0.1, -0.5e3, +2.0, (3.0e-4,0.7)]");
    assert_eq!(read("\u{feff}#usda 1.0\nfloat x = .5"), "#usda 1.0\nfloat x = 0.5");
    let same = "#usda 1.0\nfloat a1.connect = </b.c>\nasset a = @./.5/1.@ string s = \".5 1.\" float b = 1.5e-07";
    assert_eq!(read(same), same);
    for end in ["1", "1.", "1.e", "1e", "1e+", ".", ".1", "-", "-."] {
        read(end);
    }
}

#[test]
fn old_types_have_their_names_of_now() {
    assert_eq!(read("Vec3f[] a = [(1, 2, 3)] custom Matrix4d Vec3f"), "float3[] a = [(1, 2, 3)] custom matrix4d Vec3f");
    assert_eq!(read("def Vec3f \"a\" { token a = Vec3f }"), "def Vec3f \"a\" { token a = Vec3f }");
}

#[test]
fn strings_of_files_are_files() {
    let text = "def X \"a\" { asset a = \"b.png\" ( doc = \"c\" ) string s = \"d\" asset[] e = [\"f\"] }";
    assert_eq!(read(text), text.replace("\"b.png\"", "@b.png@"));
}

#[test]
fn files_as_samples_are_strings() {
    let text = "asset a.timeSamples = { 1: @@, 2: @b/'c@ } asset[] b.timeSamples = { 1: [@c@] }";
    let new = "asset a.timeSamples = { 1: '''''', 2: '''b/'c''' } asset[] b.timeSamples = { 1: [@c@] }";
    assert_eq!(read(text), new);
}

#[test]
fn comments_go_and_strings_have_no_escapes() {
    let text = "/* Bob's\n groom **/ def \"a\" # \"it's\"\rint i = 1 // x\nasset a = @http://a//b@ int j = 2 #end";
    assert_eq!(read(text), " \n def \"a\"  \rint i = 1  \nasset a = @http://a//b@ int j = 2  ");
    for (from, to) in [
        (r#"s = "\\ \"c\" it's\t""#, "s = '''\\ \"c\" it's\t'''"),
        (r#"s = '"""a'"#, r#"s = '"""a'"#),
        (r"s = 'it\'s'", "s = '''it's'''"),
        // The last quotation mark cannot stand before the fence.
        (r#"s = "it\''""#, r#"s = """it''""""#),
        (r#"s = "''' \"""#, "s = '''\u{2019}\u{2019}\u{2019} \"'''"),
    ] {
        assert_eq!(read(from), to);
    }
    let long = read(&format!("s = \"{}\"", "\\\"'".repeat(1000)));
    assert_eq!((long.matches('"').count(), long.matches('\u{2019}').count()), (1000, 1000), "{}", &long[..60]);
}

#[test]
fn samples_are_sorted_and_the_last_of_equal_times_wins() {
    let read_samples = |samples: &str| read(&format!("float a.timeSamples = {{{samples}}} int b"));
    let to = |samples: &str| format!("float a.timeSamples = {{{samples}}} int b");
    assert_eq!(read_samples(" 1: 2, 3: 4. "), to(" 1: 2.0, 3: 4.0 "));
    assert_eq!(read_samples(" 5: [(1, 2)], # c\n -1: [3],\n 3.: None "), to(" -1: [3], 3.0: None, 5: [(1, 2)], "));
    assert_eq!(read_samples("1: 2, 1: 3, 0: 4e0, 1.0: 5"), to("0: 4e0, 1.0: 5.0, "));
    assert_eq!(read_samples("0: 1, -0: 2,"), to("-0: 2.0, "));
    for bad in ["nan: 1", "1: 2, inf: 3", "-inf: 3", "1e999: 3", "1: { float b.timeSamples = { 1: 2 } }"] {
        error(&format!("float a.timeSamples = {{ {bad} }}"));
    }
    // Two attributes, and a sample with brackets of its own.
    let two = "a.timeSamples = { 2: @b@, 1: @c, d@ } b.timeSamples = { 4: (1, 2), 3: (3, 4) }";
    let sorted = "a.timeSamples = { 1: '''c, d''', 2: '''b''', } b.timeSamples = { 3: (3, 4), 4: (1, 2), }";
    assert_eq!(read(two), sorted);
}

#[test]
fn arcs_are_found() {
    let text = "#usda 1.0 ( defaultPrim = \"a\" subLayers = [@s@ (offset = 1), @t@] )
        def X \"a\" ( doc = 'x' prepend references = [ @b@</B> (offset = 1; scale = 2), @c@, <../d> ] kind = 'y' )
        { rel inherits = </no> def \"k\" ( inherits = </a/z> customData = { string references = '@no@' } ) {}
          variantSet \"v\" = { \"x\" ( payload = @p@ specializes = [</q>, <r>] ) {
            over \"m\" ( payload = None ) {} } }
          def \"n\" ( payload = </P> ) { asset references = @no@ } }";
    let arcs = normalized(text.into()).unwrap().content.arcs;
    let arc = |is_class: bool, layer: &str, prim: &str| Arc {
        is_class,
        layer: (!layer.is_empty()).then(|| layer.to_owned()),
        prim: (!prim.is_empty()).then(|| prim.to_owned()),
    };
    assert_eq!((arcs.default_prim.as_deref(), &*arcs.sublayers), (Some("a"), &["s".to_owned(), "t".to_owned()][..]));
    let of = |prim: &str| arcs.of(prim);
    assert_eq!(of("/a")[..3], [arc(false, "b", "/B"), arc(false, "c", ""), arc(false, "", "../d")]);
    assert_eq!(of("/a")[3..], [arc(false, "p", ""), arc(true, "", "/q"), arc(true, "", "r")]);
    assert_eq!((of("/a/k"), of("/a/n")), (&[arc(true, "", "/a/z")][..], &[arc(false, "", "/P")][..]));
    assert_eq!((arcs.prims(), of("/a/m").len()), (3, 0));
}

#[test]
fn arcs_and_expressions_are_bounded() {
    let list = |n: usize| format!("( references = [{}] )", "@a@</b>, ".repeat(n));
    read(&list(MOST_ARCS));
    assert!(error(&list(MOST_ARCS + 1)).contains("more than 1000 references"));
    let deep = |n: usize| format!("`{}`", "if(".repeat(n));
    read(&format!("string a = \"{0}\" asset b = @{0}@", deep(100)));
    let block = |n: usize| format!("def \"a\" {{ {} }} def \"b\" {{ int i }}", "float x ".repeat(n / 2));
    read(&block(MOST_WORDS));
    read(&format!("bool[] a = [{}]", "true, ".repeat(MOST_WORDS + 1)));
    assert!(error(&block(MOST_WORDS + 2)).contains("more than 131072 words"));
    let escapes = format!("a = '`{}`'", r"\\".repeat(101));
    for text in [format!("a = '{}'", deep(101)), format!("a = @{}@", deep(101)), escapes] {
        assert!(error(&text).contains("an expression has more than 100"));
    }
    let variables = "( expressionVariables = { string A = '`${B}${C}`' } ) string s = '`${A}`'";
    assert_eq!(normalized(variables.into()).unwrap().content.variables, 2);
    assert!(error(&format!("a = @@@{}@@@", "@b".repeat(101))).contains("more than 100 @"));
}
