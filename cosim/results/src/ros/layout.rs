//! A layout for Foxglove and Lichtblick: the bodies in three dimensions, with plots beside them.

use serde_json::{Map, Value, json};

use super::Topics;

/// The layout as a file to import.
pub(crate) fn layout(topics: &Topics) -> String {
    let named = |end: &str| {
        let names = topics.iter().filter(|topic| topic.schema_name().ends_with(end));
        names.map(|topic| format!("/{}", topic.name)).collect::<Vec<_>>()
    };
    let (bodies, fixes) = (named("/Odometry"), named("/PoseWithCovarianceStamped"));
    let shown = bodies.iter().chain(&fixes).map(|topic| {
        (topic.clone(), json!({ "visible": true, "type": "axis", "showCovariance": true }))
    });
    let shown: Map<String, Value> = shown.collect();
    let plot = |title: &str, unit: &str, fields: &[&str]| {
        let paths = bodies
            .iter()
            .flat_map(|topic| fields.iter().map(move |field| format!("{topic}.{field}")));
        let path = |value: String| json!({ "value": value, "enabled": true, "timestampMethod": "receiveTime" });
        json!({
            "title": title, "yAxisLabel": unit, "paths": paths.map(path).collect::<Vec<_>>(),
            "showLegend": true, "legendDisplay": "floating", "isSynced": true, "xAxisVal": "timestamp",
        })
    };
    let position = "pose.pose.position";
    let (x, y, z) = (format!("{position}.x"), format!("{position}.y"), format!("{position}.z"));
    let layout = json!({
        "configById": {
            "3D!bodies": {
                "followTf": super::WORLD,
                "followMode": "follow-none",
                "scene": {},
                "transforms": {},
                "topics": shown,
                "layers": { "grid": { "layerId": "foxglove.Grid", "size": 100, "divisions": 20 } },
            },
            "Plot!east": plot("East and north", "m", &[&x, &y]),
            "Plot!up": plot("Up", "m", &[&z]),
            "Plot!speed": plot("Speed forward", "m/s", &["twist.twist.linear.x"]),
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": {
            "direction": "row",
            "first": "3D!bodies",
            "second": {
                "direction": "column",
                "first": "Plot!east",
                "second": { "direction": "column", "first": "Plot!up", "second": "Plot!speed" },
                "splitPercentage": 40,
            },
            "splitPercentage": 60,
        },
    });
    format!("{layout:#}\n")
}
