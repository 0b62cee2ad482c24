//! Cells, and mistakes with their lines.

use super::*;

fn read(text: &str) -> Result<Campaign> {
    Campaign::parse(text, Path::new("/c/c.toml"))
}

#[test]
fn cells_are_all_combinations_and_a_run_has_a_place_in_one() {
    let campaign = read(
        "seeds = 3\n[systems]\na = 'a.ssd'\nb = 'b.ssd'\n[scenarios]\nnone = ''\noff = 'o.toml'\n\
         [factors]\n'p.x' = [1, 2.5]\n",
    )
    .unwrap();
    assert_eq!((campaign.cells(), campaign.runs()), (8, 24));
    assert_eq!(campaign.cell_name(0), "a/none/p.x=1");
    assert_eq!(campaign.cell_name(7), "b/off/p.x=2.5");
    assert_eq!((campaign.cell_of(17), campaign.replicate_of(17)), (1, 2));
    assert_eq!(campaign.scenarios[1].1.faults.as_deref(), Some(Path::new("/c/o.toml")));
}

#[test]
fn every_mistake_is_reported_at_once_with_its_line() {
    let text = "seeds = 0\ndesing = 'sobol'\n[systems]\n[dispersions]\n\
        'p.a' = { kind = 'normal', mean = 0, sigma = 0 }\n'p.b' = { kind = 'uniform', min = 2, max = 2 }\n\
        'p.c' = { kind = 'uniforn' }\n[figures.ate]\nkind = 'ate'\ntruth = 't'\nestimat = 'e'\n\
        [[verdict]]\nfigure = 'ade'\nat-most = 1\n[[verdict]]\nfigure = 'ate'\nquantile = 95\n";
    let error = read(text).unwrap_err();
    let found: Vec<(usize, &str)> =
        error.problems().map(|p| (p.place().unwrap().1.unwrap(), p.what())).collect();
    for (line, part) in [
        (1, "'seeds' is 0"),
        (2, "'desing' is unknown; did you mean 'design'"),
        (1, "[systems] is missing"),
        (5, "0 is not greater than 0"),
        (6, "it has no spread"),
        (7, "did you mean 'uniform'"),
        (11, "'estimat' is unknown; did you mean 'estimate'"),
        (8, "'estimate' is missing"),
        (13, "'ade' is not computed"),
        (15, "'quantile' 95 is not between 0 and 1"),
        (15, "one of 'at-most' and 'at-least'"),
    ] {
        let named = |(at, what): &(usize, &str)| *at == line && what.contains(part);
        assert!(found.iter().any(named), "{line} {part}: {found:#?}");
    }
}

#[test]
fn other_instants_are_another_campaign() {
    let identity = |more: &str| {
        let text = format!(
            "stop-time = 10\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'nis'\nnis = 'n'\n\
             count = 'c'\n{more}"
        );
        read(&text).unwrap().identity()
    };
    let usual = identity("dimension = 2\nevery = 5");
    assert_ne!(usual, identity("dimension = 2\nevery = 2"));
    assert_ne!(usual, identity("dimension = 3\nevery = 5"));
    assert_eq!(usual, identity("every = 5.0\ndimension = 2"));
}

#[test]
fn what_multiplies_to_more_than_any_memory_holds_is_refused() {
    let begin = "[systems]\na = 'a.ssd'\n";
    let factors: String = (0..40).map(|n| format!("'p.x{n}' = [1, 2, 3, 4]\n")).collect();
    let long = format!("'p.{}' = {:?}\n", "x".repeat(1 << 20), [0; 1000]);
    for text in [
        format!("seeds = 1000000000000000000\n{begin}"),
        format!("{begin}[factors]\n{factors}"),
        format!("{begin}[factors]\n{long}"),
    ] {
        let error = read(&text).unwrap_err();
        assert!(error.what().contains("more than 10000000 runs, or too many cells"), "{error}");
    }
    assert_eq!(read(&format!("seeds = 10000000\n{begin}")).unwrap().runs(), 10_000_000);
}

#[test]
fn formulas_are_bounded() {
    for (depth, allowed) in [(60, true), (65, false), (50_000, false)] {
        let formula = format!("{}{{a.y}}{}", "sin(".repeat(depth), ")".repeat(depth));
        let text = "[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'max'\nof = ";
        let read = read(&format!("{text}'{formula}'\n"));
        assert_eq!(read.is_ok(), allowed, "{depth}");
    }
}
