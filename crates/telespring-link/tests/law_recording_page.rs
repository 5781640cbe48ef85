//! The page and the layout name what is recorded, and nothing else.

mod common;
mod recorded;
mod recording;

use recorded::{Shared, items, recorder, summary};
use telespring_link::feed::Observer;

#[test]
fn law_the_page_has_every_topic_and_field() {
    let page = include_str!("../../../docs/recording.md");
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items(1900).iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let file = file.file();
    assert_eq!(file.schemas.len(), 8);
    for (topic, schema) in &file.schemas {
        assert!(page.contains(&topic.replace("site1", "siteSIDE")), "{topic}");
        assert!(page.contains(&format!("`{}`", schema.full_name())), "{}", schema.full_name());
        if ["/site1/tick", "/site1/arrival", "/site1/event"].contains(&topic.as_str()) {
            for field in schema.fields() {
                assert!(page.contains(&format!("`{}`", field.name())), "{topic} {}", field.name());
            }
        }
    }
    for (name, record) in &file.metadata {
        assert!(page.contains(&format!("metadata `{name}`")), "{name}");
        for key in record.keys() {
            assert!(page.contains(&format!("`{key}`")), "{name} {key}");
        }
    }
    for name in file.attachments.keys() {
        assert!(page.contains(&format!("attachment `{name}`")), "{name}");
    }
}

#[test]
fn law_the_layout_shows_what_is_recorded() {
    let text = include_str!("../../../examples/foxglove-layout.json");
    let layout: serde_json::Value = serde_json::from_str(text).unwrap();
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items(1900).iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let schemas = file.file().schemas;
    let schema = |topic: &str| {
        let alike = topic.replace("/site2/", "/site1/");
        schemas.get(&alike).unwrap_or_else(|| panic!("{topic}")).clone()
    };
    // every panel stands once in the tree, and has a kind that the viewers know
    let mut shown = Vec::new();
    panels(&layout["layout"], &mut shown);
    shown.sort();
    let panels = layout["configById"].as_object().unwrap();
    assert_eq!(shown, panels.keys().cloned().collect::<Vec<_>>());
    let mut paths = 0;
    for (panel, settings) in panels {
        match panel.split_once('!').unwrap().0 {
            "Plot" | "StateTransitions" => {
                for path in settings["paths"].as_array().unwrap() {
                    assert_eq!(path["timestampMethod"], "receiveTime");
                    let (topic, fields) = path["value"].as_str().unwrap().split_once('.').unwrap();
                    let mut message = Some(schema(topic));
                    for name in fields.split('.') {
                        let field = message.unwrap().get_field_by_name(name);
                        let kind = field.unwrap_or_else(|| panic!("{topic}.{fields}")).kind();
                        message = kind.as_message().cloned();
                    }
                    assert!(message.is_none(), "{topic}.{fields} is no value");
                    paths += 1;
                }
            }
            "3D" => {
                for topic in settings["topics"].as_object().unwrap().keys() {
                    assert_eq!(schema(topic).full_name(), "foxglove.PoseInFrame", "{topic}");
                }
                assert_eq!(settings["followTf"], "study");
            }
            "RosOut" => {
                let topic = settings["topicToRender"].as_str().unwrap();
                assert_eq!(schema(topic).full_name(), "foxglove.Log", "{topic}");
            }
            other => panic!("{other}"),
        }
    }
    assert!(paths > 30, "{paths}");
}

/// The panels of a tree of splits.
fn panels(node: &serde_json::Value, found: &mut Vec<String>) {
    if let Some(panel) = node.as_str() {
        found.push(panel.to_owned());
        return;
    }
    let split = node.as_object().unwrap();
    assert!(["row", "column"].contains(&split["direction"].as_str().unwrap()), "{node}");
    let share = split["splitPercentage"].as_f64().unwrap();
    assert!(share > 0.0 && share < 100.0);
    for part in ["first", "second"] {
        panels(&split[part], found);
    }
}
