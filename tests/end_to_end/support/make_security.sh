#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# make_security.sh FOLDER DOMAIN USER: the files of DDS Security for a server (FOLDER/server) and for one user
# (FOLDER/USER), who may use the topics of that user only. See common/wire/README.md. For tests: the keys of the
# authorities stay beside them.
set -e
folder=$1 domain=$2 user=$3
mkdir -p "$folder"
cd "$folder"
xml='<?xml version="1.0" encoding="UTF-8"?>'
namespace='xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
schema=http://www.omg.org/spec/DDS-Security/20170801

authority() {
  openssl ecparam -name prime256v1 -genkey -noout -out "$1_key.pem"
  openssl req -x509 -new -sha256 -key "$1_key.pem" -days 30 -out "$1.pem" -subj "/O=Tenter test/CN=$1"
}

sign() {
  openssl smime -sign -in "$1" -text -out "$2" -signer permissions_ca.pem -inkey permissions_ca_key.pem
}

topics() {
  for topic in $1; do printf '<topic>%s</topic>' "tenter/v1/$topic"; done
}

member() { # NAME, topics to publish, topics to subscribe to
  mkdir -p "$1"
  openssl ecparam -name prime256v1 -genkey -noout -out "$1/identity_key.pem"
  openssl req -new -sha256 -key "$1/identity_key.pem" -out request.csr -subj "/O=Tenter test/CN=$1"
  openssl x509 -req -sha256 -in request.csr -CA identity_ca.pem -CAkey identity_ca_key.pem -CAcreateserial \
    -days 30 -out "$1/identity.pem"
  subject=$(openssl x509 -in "$1/identity.pem" -noout -subject -nameopt RFC2253 | sed 's/^subject=//')
  cat >permissions.xml <<XML
$xml
<dds $namespace xsi:noNamespaceSchemaLocation="$schema/omg_shared_ca_permissions.xsd"><permissions>
<grant name="$1"><subject_name>$subject</subject_name>
<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2038-01-01T00:00:00</not_after></validity>
<allow_rule><domains><id>$domain</id></domains>
<publish><topics>$(topics "$2")</topics></publish><subscribe><topics>$(topics "$3")</topics></subscribe>
</allow_rule><default>DENY</default></grant></permissions></dds>
XML
  sign permissions.xml "$1/permissions.p7s"
  sign governance.xml "$1/governance.p7s"
  cp identity_ca.pem permissions_ca.pem "$1"
}

authority identity_ca
authority permissions_ca
cat >governance.xml <<XML
$xml
<dds $namespace xsi:noNamespaceSchemaLocation="$schema/omg_shared_ca_governance.xsd"><domain_access_rules><domain_rule>
<domains><id>$domain</id></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>ENCRYPT</rtps_protection_kind>
<topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>NONE</metadata_protection_kind><data_protection_kind>NONE</data_protection_kind>
</topic_rule></topic_access_rules></domain_rule></domain_access_rules></dds>
XML
set -f
member server '*' '*'
member "$user" "presence request/$user chunk_up/$user/*" \
  "server job_state job_event fit_progress reply/$user chunk_down/$user/* chunk_ack/$user/*"
