//! The descriptor.

use cosplat_core::control::PROTOCOL;
use cosplat_core::plugin::Descriptor;

use crate::Make;
use crate::rule::Rule;
use crate::trial::{Verdict, bits};

pub(crate) fn check(make: Make<'_>, verdict: &mut Verdict) {
    let plugin = make();
    let first = plugin.describe();
    verdict.must(bits(&first) == bits(&plugin.describe()), Rule::DescribeAlways, || "two answers differ".into());
    verdict.must(bits(&first) == bits(&make().describe()), Rule::DescribeAlways, || "two instances differ".into());
    sane(&first, verdict);
    let back = serde_json::to_string(&first).and_then(|text| serde_json::from_str::<Descriptor>(&text));
    match back {
        Ok(back) => verdict.must(back == first, Rule::DescriptorJson, || "it comes back changed".into()),
        Err(why) => verdict.add(Rule::DescriptorJson, why.to_string()),
    }
}

fn sane(d: &Descriptor, verdict: &mut Verdict) {
    let mut must = |holds: bool, what: String| verdict.must(holds, Rule::DescriptorSane, || what);
    let legal = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    must(!d.name.is_empty() && d.name.chars().all(legal), format!("name `{}` is not of the form [a-z0-9-]+", d.name));
    must(!d.version.is_empty(), "no version".into());
    must(!d.summary.is_empty() && !d.summary.contains('\n'), "the summary is not one line".into());
    let [low, high] = d.protocol;
    must(
        low <= PROTOCOL && PROTOCOL <= high,
        format!("protocol {low} to {high} does not hold {PROTOCOL}, the one of this kit"),
    );
    must(!d.body_kinds.is_empty(), "it takes no kind of body".into());
    must(!d.materials.is_empty(), "it takes no material".into());
    for (what, list) in [("body kind", &d.body_kinds), ("material", &d.materials), ("feature", &d.features)] {
        for (i, entry) in list.iter().enumerate() {
            must(!entry.is_empty() && !list[..i].contains(entry), format!("{what} `{entry}` is empty or listed twice"));
        }
    }
    must(d.saves.bytes || !d.saves.deterministic, "it restores bitwise what it cannot save".into());
    must(d.params_schema.is_object(), "the schema of its parameters is no JSON object".into());
}
