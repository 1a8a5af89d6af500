//! OpenMetrics as Prometheus' older text format, which more programs read.
//!
//! The samples are the same. The older format names a counter with its `_total` and an
//! information with its `_info` also where it says their types, knows no units and no end.

/// The same in text format 0.0.4.
pub(super) fn plain(openmetrics: &str) -> String {
    let mut plain = String::with_capacity(openmetrics.len());
    // HELP comes before TYPE, which decides the name in both.
    let mut help: Option<(&str, &str)> = None;
    for line in openmetrics.lines() {
        if let Some(rest) = line.strip_prefix("# HELP ") {
            help = rest.split_once(' ');
        } else if let Some((name, kind)) = typed(line) {
            let (suffix, kind) = match kind {
                "counter" => ("_total", "counter"),
                "info" => ("_info", "gauge"),
                "unknown" => ("", "untyped"),
                other => ("", other),
            };
            if let Some((of, text)) = help.take().filter(|(of, _)| *of == name) {
                push(&mut plain, &["# HELP ", of, suffix, " ", text]);
            }
            push(&mut plain, &["# TYPE ", name, suffix, " ", kind]);
        } else if !line.starts_with("# UNIT ") && line != "# EOF" {
            push(&mut plain, &[line]);
        }
    }
    plain
}

fn typed(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("# TYPE ")?.split_once(' ')
}

fn push(text: &mut String, pieces: &[&str]) {
    pieces.iter().for_each(|piece| text.push_str(piece));
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_and_information_get_their_whole_names() {
        let openmetrics = "\
# HELP a Things.
# TYPE a counter
a_total{b=\"# TYPE\"} 3
# HELP c_seconds Time.
# TYPE c_seconds histogram
# UNIT c_seconds seconds
c_seconds_sum 1.0
# HELP d What.
# TYPE d info
d_info{v=\"1\"} 1
# EOF
";
        let expected = "\
# HELP a_total Things.
# TYPE a_total counter
a_total{b=\"# TYPE\"} 3
# HELP c_seconds Time.
# TYPE c_seconds histogram
c_seconds_sum 1.0
# HELP d_info What.
# TYPE d_info gauge
d_info{v=\"1\"} 1
";
        assert_eq!(plain(openmetrics), expected);
    }
}
